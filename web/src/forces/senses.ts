// SPDX-License-Identifier: MIT
// Makes the force perceptible without a force device: the sound of the cut, and the vibration of a
// phone or a game controller.

import { TICK_NUMBERS } from "../connection/wire";

export class Senses {
  sound = false;
  rumble = false;
  private audio: { context: AudioContext; gain: GainNode; filter: BiquadFilterNode } | null = null;
  private rumbledAt = 0;

  /** Takes rows of tip, force, moment and axis. */
  feel(rows: Float32Array, rate: number): void {
    const ticks = rows.length / TICK_NUMBERS;
    if (ticks === 0) return;
    let sum = 0,
      change = 0,
      way = 0;
    for (let i = 0; i < rows.length; i += TICK_NUMBERS) {
      const f = Math.hypot(rows[i + 3], rows[i + 4], rows[i + 5]);
      sum += f;
      const b = i - TICK_NUMBERS; // the previous tick
      if (b >= 0) {
        change += Math.abs(f - Math.hypot(rows[b + 3], rows[b + 4], rows[b + 5]));
        way += Math.hypot(rows[i] - rows[b], rows[i + 1] - rows[b + 1], rows[i + 2] - rows[b + 2]);
      }
    }
    const force = sum / ticks,
      speed = ticks > 1 ? (way / (ticks - 1)) * rate : 0;
    if (this.sound) this.play(force, change / ticks, speed);
    if (this.rumble) this.shake(force);
  }

  silence(): void {
    if (this.audio) this.audio.gain.gain.setTargetAtTime(0, this.audio.context.currentTime, 0.03);
  }

  /** A scraping noise. Its volume follows the force; its pitch rises with speed and roughness. */
  private play(force: number, rough: number, speed: number): void {
    this.audio ??= this.make();
    const { context, gain, filter } = this.audio;
    const moving = Math.min(1, speed / 20);
    const now = context.currentTime;
    gain.gain.cancelScheduledValues(now);
    gain.gain.setTargetAtTime(0.35 * (1 - Math.exp(-force / 1.5)) * moving, now, 0.02);
    gain.gain.setTargetAtTime(0, now + 0.25, 0.03); // if no tick follows
    filter.frequency.setTargetAtTime(
      300 + 20 * Math.min(150, speed) + 4000 * Math.min(0.3, rough),
      context.currentTime,
      0.03,
    );
  }

  private make(): { context: AudioContext; gain: GainNode; filter: BiquadFilterNode } {
    const context = new AudioContext();
    const noise = context.createBuffer(1, 2 * context.sampleRate, context.sampleRate);
    const samples = noise.getChannelData(0);
    for (let i = 0; i < samples.length; i++) samples[i] = 2 * Math.random() - 1;
    const source = new AudioBufferSourceNode(context, { buffer: noise, loop: true });
    const filter = new BiquadFilterNode(context, { type: "bandpass", Q: 0.9, frequency: 600 });
    const gain = new GainNode(context, { gain: 0 });
    source.connect(filter).connect(gain).connect(context.destination);
    source.start();
    return { context, gain, filter };
  }

  private shake(force: number): void {
    const now = performance.now();
    if (now - this.rumbledAt < 80 || force < 0.02) return;
    this.rumbledAt = now;
    const strong = Math.min(1, force / 4);
    // A phone's vibration is on or off. A longer pulse feels stronger.
    if ("vibrate" in navigator) navigator.vibrate(Math.round(8 + 60 * strong));
    for (const pad of navigator.getGamepads())
      void pad?.vibrationActuator
        ?.playEffect("dual-rumble", {
          duration: 120,
          strongMagnitude: strong,
          weakMagnitude: 0.6 * strong,
        })
        .catch(() => undefined);
  }
}
