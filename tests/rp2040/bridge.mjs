// SPDX-License-Identifier: MIT
// UART1 of a board as a TCP port, which is printed: usage: node bridge.mjs IMAGE. The board is never ahead of the clock on
// the wall, and behind it where the machine is slow.
import net from "node:net";

import { Flash } from "./flash.mjs";
import { HZ, Pico, ms } from "./pico.mjs";

const CHARACTER = 10 * HZ / 1e6, SLICE = ms(1);

const pico = new Pico(process.argv[2]);
new Flash(pico);
let client = null, feedAt = 0;
pico.chip.uart[1].onByte = (byte) => client?.write(Buffer.of(byte));

const server = net.createServer({ noDelay: true }, (socket) => {
  client = socket;
  socket.on("data", (bytes) => {
    feedAt = Math.max(feedAt, pico.cycle);
    for (const byte of bytes) {
      feedAt += CHARACTER;
      pico.at(Math.round(feedAt), () => pico.chip.uart[1].feedByte(byte));
    }
  });
  socket.on("error", () => {});
  socket.on("close", () => process.exit(0));
});
server.listen(0, "127.0.0.1", () => console.log(server.address().port));

const begun = Date.now();
function slice() {
  const ahead = pico.cycle / ms(1) - (Date.now() - begun);
  if (ahead <= 0) pico.run(SLICE);
  if (ahead <= 0) setImmediate(slice);
  else setTimeout(slice, Math.ceil(ahead));
}
slice();
