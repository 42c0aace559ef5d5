"""The kernel as an arm64 processor runs it: its library, loaded into an emulator that works on this process's arrays.

The emulator's memory is this process's own, at the same addresses, so that functions take the arrays that they take
natively. Of a library's links there is what the kernel has: its own functions, `memcpy` and `memset`.
"""

from __future__ import annotations

import ctypes
import mmap
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import unicorn
from unicorn import arm64_const as arm

from purcell_cli.kernel.library import _SIGNATURES

_BLOCK = 1 << 20
"""Memory that is shown to the emulator at once, where it first reads or writes [bytes]."""
_STACK = 8 << 20
"""What the emulator's stack takes [bytes], as much as a thread's on Linux."""
_RETURN = struct.pack("<I", 0xD65F03C0)
"""The instruction `ret`."""
_RELATIVE, _DATA, _FUNCTION = 1027, 1025, 1026
"""Kinds of links in a library for arm64: an address in it, and those of symbols."""
_WHOLES = [getattr(arm, f"UC_ARM64_REG_X{k}") for k in range(8)]
_NUMBERS = [getattr(arm, f"UC_ARM64_REG_D{k}") for k in range(8)]


class EmulatedKernel:
    """A library for arm64, with the functions of the native one."""

    def __init__(self, file: Path) -> None:
        data = file.read_bytes()
        assert data[:6] == b"\x7fELF\x02\x01", "64 bits, the least first"
        assert struct.unpack_from("<H", data, 18) == (183,), "for arm64"
        start, size, count = *struct.unpack_from("<Q", data, 32), *struct.unpack_from("<HH", data, 54)
        parts = [struct.unpack_from("<IIQQQQQQ", data, start + size * k) for k in range(count)]
        loaded = [part for part in parts if part[0] == 1]
        dynamic = next(part[3] for part in parts if part[0] == 2)
        length = -(-max(part[3] + part[6] for part in loaded) // _BLOCK) * _BLOCK
        self._memory = mmap.mmap(-1, length + _STACK)
        for _, _, offset, place, _, stored, _, _ in loaded:
            self._memory[place : place + stored] = data[offset : offset + stored]
        self._base = ctypes.addressof(ctypes.c_char.from_buffer(self._memory))
        self._stack = self._base + length + _STACK
        self._end = self._base + length - 4
        outside = {"memcpy": self._end - 8, "memset": self._end - 4}
        for place in (*outside.values(), self._end):
            self._memory[place - self._base : place - self._base + 4] = _RETURN
        self.functions = self._linked(dynamic, outside)
        self._machine = unicorn.Uc(unicorn.UC_ARCH_ARM64, unicorn.UC_MODE_ARM)
        self._machine.mem_map_ptr(self._base, length + _STACK, unicorn.UC_PROT_ALL, self._base)
        self._machine.reg_write(arm.UC_ARM64_REG_CPACR_EL1, 3 << 20)  # floating point is not trapped
        self._machine.hook_add(unicorn.UC_HOOK_MEM_UNMAPPED, self._show)
        for name, place in outside.items():
            self._machine.hook_add(unicorn.UC_HOOK_CODE, self._outside, name, place, place)

    def _linked(self, dynamic: int, outside: dict[str, int]) -> dict[str, int]:
        """Set the addresses in a library that depend on where it is loaded, and return those of its functions."""
        tags: dict[int, int] = {}
        for place in range(dynamic, len(self._memory), 16):
            tag, value = struct.unpack_from("<qQ", self._memory, place)
            if tag == 0:
                break
            tags[tag] = value
        strings, symbols, hashes, count = tags[5], tags[6], tags[4], 0
        (count,) = struct.unpack_from("<I", self._memory, hashes + 4)
        found, names = {}, []
        for k in range(count):
            text, _, _, section, value, _ = struct.unpack_from("<IBBHQQ", self._memory, symbols + 24 * k)
            name = self._memory[strings + text : self._memory.find(b"\0", strings + text)].decode()
            names.append(name)
            if section:
                found[name] = self._base + value
        known = outside | found
        for links, size in ((tags.get(7, 0), tags.get(8, 0)), (tags.get(23, 0), tags.get(2, 0))):
            for link in range(links, links + size, 24):
                place, kind, more = struct.unpack_from("<QQq", self._memory, link)
                assert kind & 0xFFFFFFFF in {_RELATIVE, _DATA, _FUNCTION}, "another kind of link"
                target = self._base if kind & 0xFFFFFFFF == _RELATIVE else known[names[kind >> 32]]
                struct.pack_into("<Q", self._memory, place, target + more)
        return found

    def _show(self, machine: Any, _kind: int, address: int, _size: int, _value: int, _data: object) -> bool:
        """Show the emulator the memory at an address, and go on."""
        if address < _BLOCK:
            return False
        block = address // _BLOCK * _BLOCK
        machine.mem_map_ptr(block, _BLOCK, unicorn.UC_PROT_READ | unicorn.UC_PROT_WRITE, block)
        return True

    def _outside(self, machine: Any, _address: int, _size: int, name: str) -> None:
        """Do what a function of the C library does."""
        to, value, count = (machine.reg_read(register) for register in _WHOLES[:3])
        (ctypes.memmove if name == "memcpy" else ctypes.memset)(to, value, count)

    def __getattr__(self, name: str) -> Callable[..., Any]:
        """Return a function of the library, called as the native one is."""
        returned, taken = _SIGNATURES[name.removeprefix("purcell_")]
        start = self.functions[name]

        def call(*arguments: Any) -> Any:
            numbers = [float(a) for a, kind in zip(arguments, taken, strict=True) if kind is ctypes.c_double]
            wholes = [int(a or 0) for a, kind in zip(arguments, taken, strict=True) if kind is not ctypes.c_double]
            assert len(numbers) <= len(_NUMBERS), "more numbers than registers"
            machine = self._machine
            for register, number in zip(_NUMBERS, numbers, strict=False):
                machine.reg_write(register, struct.unpack("<Q", struct.pack("<d", number))[0])
            for register, whole in zip(_WHOLES, wholes, strict=False):
                machine.reg_write(register, whole & 0xFFFFFFFFFFFFFFFF)
            more = struct.pack(f"<{len(wholes[8:])}q", *wholes[8:])
            stack = self._stack - (len(more) + 15) // 16 * 16
            ctypes.memmove(stack, more, len(more))
            machine.reg_write(arm.UC_ARM64_REG_SP, stack)
            machine.reg_write(arm.UC_ARM64_REG_LR, self._end)
            machine.emu_start(start, self._end)
            if returned is ctypes.c_double:
                return struct.unpack("<d", struct.pack("<Q", machine.reg_read(_NUMBERS[0]) & 0xFFFFFFFFFFFFFFFF))[0]
            return None if returned is None else ctypes.c_int64(machine.reg_read(_WHOLES[0])).value

        return call
