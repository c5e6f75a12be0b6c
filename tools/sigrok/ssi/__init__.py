# SPDX-License-Identifier: MIT
'''
Encoders with SSI, the synchronous serial interface: the first falling edge of the clock stores the
position, each rising edge shifts a bit of it out, and it is over when the clock has been silent for
the monoflop time. Clocked on before that, the same word comes again behind a 0.
'''
from .pd import Decoder
