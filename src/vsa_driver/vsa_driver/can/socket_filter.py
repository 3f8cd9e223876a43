# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Kernel filter of a datagram socket (classic BPF): dropped datagrams do not wake the process."""

import ctypes
import os
import socket
import struct
from collections.abc import Sequence

_SO_ATTACH_FILTER = 26  # <asm-generic/socket.h>; the socket module lacks the name
_UDP_HEADER = 8  # offset 0 of the filter is the header

# Classic BPF, <linux/bpf_common.h>: load a byte or a big-endian half word, compare, return.
_LOAD_BYTE, _LOAD_HALF, _JUMP_EQUAL, _RETURN = 0x30, 0x28, 0x15, 0x06
_ACCEPT = 0xFFFFFFFF


def drop_datagrams(descriptor: int, marker_at: int, marker: int, words: Sequence[int]) -> None:
    """Drop datagrams whose byte at `marker_at` is `marker` and whose next two, big-endian, are one of `words`.

    Raises OSError where the kernel does not support filters.
    """
    program = [(_LOAD_BYTE, 0, 0, _UDP_HEADER + marker_at), (_JUMP_EQUAL, 0, len(words) + 1, marker)]
    program.append((_LOAD_HALF, 0, 0, _UDP_HEADER + marker_at + 1))
    program += [(_JUMP_EQUAL, len(words) - i, 0, word) for i, word in enumerate(words)]
    program += [(_RETURN, 0, 0, _ACCEPT), (_RETURN, 0, 0, 0)]
    code = ctypes.create_string_buffer(b"".join(struct.pack("HBBI", *instruction) for instruction in program))
    with socket.socket(fileno=os.dup(descriptor)) as handle:
        # struct sock_fprog: number of instructions, padded, and their address
        handle.setsockopt(socket.SOL_SOCKET, _SO_ATTACH_FILTER, struct.pack("HL", len(program), ctypes.addressof(code)))
