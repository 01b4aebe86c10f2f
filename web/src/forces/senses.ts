// SPDX-License-Identifier: MIT
// Plays the force as sound and vibration for users without a force device. The sound is that of a
// cut. A phone or a game controller vibrates.

import { TICK_NUMBERS } from "../connection/wire";

export class Senses {
  sound = false;
  rumble = false;
  private audio: { context: AudioContext; gain: GainNode; filter: BiquadFilterNode } | null = null;
  private rumbledAt = 0;

  /** Takes rows of tip, force, moment, axis and side at `rate` ticks per second. */
  update(rows: Float32Array, rate: number): void {
    const ticks = rows.length / TICK_NUMBERS;
    if (ticks === 0) return;
    let sum = 0,
      change = 0,
      distance = 0;
    for (let i = 0; i < rows.length; i += TICK_NUMBERS) {
      const f = Math.hypot(rows[i + 3], rows[i + 4], rows[i + 5]);
      sum += f;
      const b = i - TICK_NUMBERS; // the previous tick
      if (b >= 0) {
        change += Math.abs(f - Math.hypot(rows[b + 3], rows[b + 4], rows[b + 5]));
        distance += Math.hypot(
          rows[i] - rows[b],
          rows[i + 1] - rows[b + 1],
          rows[i + 2] - rows[b + 2],
        );
      }
    }
    const force = sum / ticks,
      speed = ticks > 1 ? (distance / (ticks - 1)) * rate : 0;
    if (this.sound) this.play(force, change / ticks, speed);
    if (this.rumble) this.shake(force);
  }

  silence(): void {
    if (this.audio) this.audio.gain.gain.setTargetAtTime(0, this.audio.context.currentTime, 0.03);
  }

  /** Plays a scraping noise. The force sets its volume. Speed and roughness set its brightness. */
  private play(force: number, rough: number, speed: number): void {
    this.audio ??= this.make();
    const { context, gain, filter } = this.audio;
    const moving = Math.min(1, speed / 20);
    const now = context.currentTime;
    gain.gain.cancelScheduledValues(now);
    gain.gain.setTargetAtTime(0.35 * (1 - Math.exp(-force / 1.5)) * moving, now, 0.02);
    gain.gain.setTargetAtTime(0, now + 0.25, 0.03); // fades out if no tick follows
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
    // A phone's motor has only on and off, so a longer pulse means a stronger one.
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
