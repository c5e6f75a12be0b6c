# SPDX-License-Identifier: MIT
'''
Commands and status messages: manual of the Sendix S36, chapters 5.1.2 and 5.1.3. In the words a sign and a
number of bytes stand for data, MSB first:
  # hexadecimal   @ decimal   % decimal with sign   $ ASCII   & all that is left, hexadecimal
'''
# code: (data bytes of the request, of the reply, as (least, most); longest reaction in ms; words of both)
COMMANDS = {
    0x42: ((0, 0), (4, 4), 10, 'read position', 'position @4'),
    0x43: ((5, 5), (0, 0), 40, 'set position @4, code #1', 'position set'),
    0x44: ((1, 1), (3, 3), 5, 'read analog value #1', 'analog value #1: %2'),
    0x46: ((0, 0), (3, 3), 5, 'read counter', 'counter @3'),
    0x47: ((0, 0), (0, 0), 30, 'increment counter', 'counter incremented'),
    0x49: ((1, 1), (0, 0), 30, 'erase counter, code #1', 'counter erased'),
    0x4A: ((4, 4), (4, 131), 30, 'read data field #1 offset #1 count @1, code #1',
           'data field #1 offset #1 count @1:&'),
    0x4B: ((5, 132), (3, 3), 250, 'save data field #1 offset #1 count @1, code #1:&',
           'data field #1 offset #1 count @1 saved'),
    0x4C: ((1, 1), (2, 2), 5, 'determine data field status #1', 'data field #1 status #1'),
    0x4D: ((3, 3), (2, 2), 70, 'create data field #1 status #1, code #1', 'data field #1 created, status #1'),
    0x4E: ((0, 0), (2, 2), 5, 'determine available memory area', 'memory blocks free @1, data fields @1'),
    0x4F: ((3, 3), (1, 1), 40, 'modify access key @1 from #1 to #1', 'access key @1 modified'),
    0x50: ((0, 0), (1, 1), 5, 'read encoder status', 'status'),
    0x52: ((0, 0), (4, 4), 5, 'read type label', 'type label: UART #1, type #1, memory blocks @1, option #1'),
    0x53: ((0, 0), (0, 0), None, 'reset encoder', 'encoder reset'),
    0x55: ((2, 2), (0, 0), 40, 'assign address #1, code #1', 'address assigned'),
    0x56: ((0, 0), (37, 37), 5, 'read serial number and version', 'serial number $9, version $20, date $8'),
    0x57: ((2, 2), (1, 1), 40, 'configure serial interface #1, code #1', 'serial interface #1'),
    0x6A: ((5, 5), (4, 4), 40, 'set position with synchronization @4, code #1', 'position @4'),
}

ERRORS = {
    0x00: 'no error',
    0x01: 'faulty compensation data',
    0x02: 'faulty internal angular offset',
    0x03: 'data field partitioning table destroyed',
    0x05: 'internal I2C bus not operational',
    0x06: 'internal check sum error',
    0x08: 'counter overflow',
    0x0A: 'check sum error',
    0x0B: 'unknown command code',
    0x0C: 'wrong command length',
    0x0D: 'wrong argument',
    0x0E: 'data field may not be written',
    0x0F: 'wrong access code',
    0x10: 'insufficient memory',
    0x11: 'address outside of the data field',
    0x12: 'wrong data field number',
    0x1D: 'LED current',
    0x1E: 'temperature',
    0x1F: 'speed too high',
    0x20: 'singleturn',
    0x21: 'multiturn amplitude',
    0x22: 'multiturn synchronization',
    0x23: 'multiturn vector length',
}
