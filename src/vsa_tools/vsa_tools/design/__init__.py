"""Design of the spring and its cam, section II-B. Input: specification. Output: design.csv, cam_mm.csv, pictures.

Permitted imports: vsa_common, numpy, scipy, yaml
"""
