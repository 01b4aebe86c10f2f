// SPDX-License-Identifier: MIT
// The connection to the studio. After it breaks, it retries for a minute on its own, and later on
// request.
import { entered, key, whyRefused } from "./access";
import { read, write, PROTOCOL_VERSION, type FromStudio } from "./messages";

const FIRST_WAIT_MS = 250,
  LONGEST_WAIT_MS = 8000;
const TRIES_MS = 60000; // after this time without an answer, only the user can retry
const GONE =
  "The studio does not answer: it has ended, or this computer slept. Start 'kibori studio' again in a terminal and open the address that it prints.";
const FULL = "Too many windows of the studio are open: close some, and try again.";
const REFUSED = 1008,
  TOO_MANY = 1013; // close code of the studio

/** The handler of each message from the studio. */
export type Handlers = {
  [Kind in FromStudio["kind"]]: (message: Extract<FromStudio, { kind: Kind }>["message"]) => void;
};

export class Connection {
  private waiting: { kind: FromStudio["kind"]; done: () => void }[] = [];
  private socket: WebSocket | null = null;
  private wait = FIRST_WAIT_MS;
  private lostAt = 0; // 0: connected
  private timer = 0;

  /**
   * `lost` receives what the user should do about a broken connection, and whether the page
   * retries; null: connected.
   */
  constructor(
    private handlers: Handlers,
    private lost: (why: { text: string; trying: boolean } | null) => void,
  ) {
    void entered.then(() => this.open());
  }

  send(message: Uint8Array): void {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(message);
  }

  /**
   * Resolves when the studio has handled all messages so far and has reported its state. Requires
   * an open document.
   */
  async answered(): Promise<void> {
    const heard = this.next("Mass");
    this.send(write.AskMass());
    // If the connection breaks, the question is lost.
    const again = window.setInterval(() => this.send(write.AskMass()), 2000);
    await heard;
    window.clearInterval(again);
    await this.next("State");
  }
  /** Resolves with the next message of the given kind. */
  next(kind: FromStudio["kind"]): Promise<void> {
    return new Promise((done) => this.waiting.push({ kind, done }));
  }
  private take({ kind, message }: FromStudio): void {
    (this.handlers[kind] as (message: unknown) => void)(message);
    const due = this.waiting.filter((one) => one.kind === kind);
    this.waiting = this.waiting.filter((one) => one.kind !== kind);
    for (const one of due) one.done();
  }

  /** Simulates a broken connection. */
  breakOff(): void {
    this.socket?.close();
  }

  /** Retries at once, then for another minute. */
  again(): void {
    this.lostAt = performance.now();
    this.wait = FIRST_WAIT_MS;
    this.lost({ text: GONE, trying: true });
    this.open();
  }

  private open(): void {
    window.clearTimeout(this.timer);
    // Drops a connection that is still being opened.
    if (this.socket) {
      this.socket.onclose = null;
      this.socket.close();
    }
    const socket = new WebSocket(`ws://${location.host}/ws`);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => socket.send(write.Hello({ version: PROTOCOL_VERSION, key: key() }));
    socket.onmessage = (event) => {
      if (this.lostAt > 0) {
        this.lostAt = 0;
        this.wait = FIRST_WAIT_MS;
        this.lost(null);
      }
      this.take(read(event.data as ArrayBuffer));
    };
    socket.onclose = (event) => this.closed(event.code);
    this.socket = socket;
  }

  private closed(code: number): void {
    const now = performance.now();
    this.lostAt ||= now;
    if (code === REFUSED) return this.lost({ text: whyRefused(), trying: false });
    if (code === TOO_MANY) return this.lost({ text: FULL, trying: false });
    if (now - this.lostAt > TRIES_MS) return this.lost({ text: GONE, trying: false });
    this.lost({ text: GONE, trying: true });
    this.timer = window.setTimeout(() => this.open(), this.wait);
    this.wait = Math.min(LONGEST_WAIT_MS, 2 * this.wait);
  }
}
