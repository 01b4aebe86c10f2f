// SPDX-License-Identifier: MIT
// Encodes and decodes the messages of protocol/messages.json.
import type { Vec3 } from "../base/vec3";
import { MODELS, MODES, type Mode, type Model, type Tool } from "./kinds";

/** Numbers per tick in Ticks: tip, force, moment, axis, side. */
export const TICK_NUMBERS = 15;

export class Writer {
  private bytes = new Uint8Array(64);
  private view = new DataView(this.bytes.buffer);
  private at = 0;

  constructor(kind: number) {
    this.u8(kind);
  }
  private room(count: number): number {
    const at = this.at;
    this.at += count;
    if (this.at > this.bytes.length) {
      const grown = new Uint8Array(2 * this.at);
      grown.set(this.bytes);
      this.bytes = grown;
      this.view = new DataView(grown.buffer);
    }
    return at;
  }
  u8(value: number): this {
    const at = this.room(1);
    this.view.setUint8(at, value);
    return this;
  }
  u16(value: number): this {
    const at = this.room(2);
    this.view.setUint16(at, value, true);
    return this;
  }
  u32(value: number): this {
    const at = this.room(4);
    this.view.setUint32(at, value, true);
    return this;
  }
  f64(value: number): this {
    const at = this.room(8);
    this.view.setFloat64(at, value, true);
    return this;
  }
  vec3(value: Vec3): this {
    return this.f64(value[0]).f64(value[1]).f64(value[2]);
  }
  raw(value: Uint8Array): this {
    this.u32(value.length);
    const at = this.room(value.length);
    this.bytes.set(value, at);
    return this;
  }
  text(value: string): this {
    return this.raw(new TextEncoder().encode(value));
  }
  mode(value: Mode): this {
    return this.u8(MODES.indexOf(value));
  }
  model(value: Model): this {
    return this.u8(MODELS.indexOf(value));
  }
  tool(value: Tool | null): this {
    return this.text(JSON.stringify(value));
  }
  done(): Uint8Array {
    return this.bytes.subarray(0, this.at);
  }
}

export class Reader {
  private view: DataView;
  private at = 0;

  constructor(private data: ArrayBuffer) {
    this.view = new DataView(data);
  }
  private step(count: number): number {
    const at = this.at;
    this.at += count;
    return at;
  }
  u8(): number {
    return this.view.getUint8(this.step(1));
  }
  u16(): number {
    return this.view.getUint16(this.step(2), true);
  }
  i16(): number {
    return this.view.getInt16(this.step(2), true);
  }
  u32(): number {
    return this.view.getUint32(this.step(4), true);
  }
  f32(): number {
    return this.view.getFloat32(this.step(4), true);
  }
  f64(): number {
    return this.view.getFloat64(this.step(8), true);
  }
  vec3(): Vec3 {
    return [this.f64(), this.f64(), this.f64()];
  }
  raw(): Uint8Array {
    const count = this.u32();
    const at = this.step(count);
    if (this.at > this.view.byteLength) throw new Error("a message ends too soon");
    return new Uint8Array(this.data, at, count);
  }
  text(): string {
    return new TextDecoder().decode(this.raw());
  }
  mode(): Mode {
    return MODES[this.u8()];
  }
  tool(): Tool | null {
    return JSON.parse(this.text()) as Tool | null;
  }
  get more(): boolean {
    return this.at < this.view.byteLength;
  }
  end<T>(value: T): T {
    if (this.at !== this.view.byteLength) throw new Error("a message is too long");
    return value;
  }
}
