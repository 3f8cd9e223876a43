# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Design of the spring and its cam, section II-B. Input: specification. Output: design.csv, cam_mm.csv, pictures.

Permitted imports: vsa_common, numpy, scipy, yaml
"""
