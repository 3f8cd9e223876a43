"""CAN bus and DBC files. Input: interface parameters, frames. Output: frames with capture time, signal values.

Permitted imports: vsa_common, vsa_driver.tuning, can, cantools, ament_index_python
"""
