# SPDX-License-Identifier: MIT
'''
Registers and commands over BiSS-C: each frame carries one bit in each direction, CDM and CDS. They add
up to control frames: reads and writes of registers, one after the other, and commands.

A control frame begins behind 14 frames with CDM = 0: what was going on when the recording began is
passed over.
'''
from .pd import Decoder
