# SPDX-License-Identifier: MIT
'''
The parameter channel of HIPERFACE-compatible encoders, on RS485 at 600 to 38400 baud: requests with
address, command, data and check sum, and their answers.

Stack it on 'UART', with the parity of the line (even as delivered): RX has the requests and TX the
replies, or RX has both, as a logic analyser at the line sees them.
'''
from .pd import Decoder
