// SPDX-License-Identifier: MIT
// The line to the studio: comes back by itself when it breaks.
import { read, write, PROTOCOL_VERSION, type FromStudio } from "./messages";

export class Connection {
  private socket: WebSocket | null = null;
  private wait = 250;

  constructor(
    private hear: (message: FromStudio) => void,
    private lost: (why: string) => void,
  ) {
    this.open();
  }

  send(message: Uint8Array): void {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(message);
  }

  /** As if the line had broken. */
  breakOff(): void {
    this.socket?.close();
  }

  private open(): void {
    const socket = new WebSocket(`ws://${location.host}/ws`);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.wait = 250;
      socket.send(write.Hello({ version: PROTOCOL_VERSION }));
    };
    socket.onmessage = (event) => this.hear(read(event.data as ArrayBuffer));
    socket.onclose = () => {
      this.lost("The studio does not answer. Is 'kibori studio' still running? Trying again ...");
      setTimeout(() => this.open(), this.wait);
      this.wait = Math.min(4000, 2 * this.wait);
    };
    this.socket = socket;
  }
}
