# SPDX-License-Identifier: MIT
'''
BiSS-C: the master clocks (MA), one to three slaves answer (SLO) with position, error and warning bit,
life counter and CRC. MA and SLO are sampled where the master has them; the delay of the cable is
measured in each frame, from the second rising edge of MA to Ack.

Stack 'BiSS-C registers' on it for what the bits CDM and CDS of many frames add up to.
'''
from .pd import Decoder
