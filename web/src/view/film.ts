// SPDX-License-Identifier: MIT
// Encodes pictures as a film: WebCodecs (VP8) in a WebM container. Each frame has its nominal time,
// independent of the drawing time.

interface Frame {
  ms: number;
  key: boolean;
  data: Uint8Array;
}

const KEY_EVERY_S = 1;
const BITS_A_PIXEL = 0.2;

/** True if this browser can make films. */
export const canFilm = (): boolean => typeof VideoEncoder === "function";

export class Film {
  private frames: Frame[] = [];
  private encoder: VideoEncoder;
  private failed: Error | null = null;

  constructor(
    private width: number,
    private height: number,
    private rate: number,
  ) {
    this.encoder = new VideoEncoder({
      output: (chunk) => {
        const data = new Uint8Array(chunk.byteLength);
        chunk.copyTo(data);
        this.frames.push({
          ms: Math.round(chunk.timestamp / 1000),
          key: chunk.type === "key",
          data,
        });
      },
      error: (error) => (this.failed = error),
    });
    this.encoder.configure({
      codec: "vp8",
      width,
      height,
      framerate: rate,
      bitrate: Math.round(width * height * rate * BITS_A_PIXEL),
    });
  }

  /** Adds the next frame. Resolves when there is room for another. */
  async add(picture: HTMLCanvasElement, index: number): Promise<void> {
    const frame = new VideoFrame(picture, {
      timestamp: Math.round((1e6 * index) / this.rate),
      duration: Math.round(1e6 / this.rate),
    });
    this.encoder.encode(frame, {
      keyFrame: index % Math.max(1, Math.round(KEY_EVERY_S * this.rate)) === 0,
    });
    frame.close();
    while (this.encoder.encodeQueueSize > 3 && !this.failed)
      await new Promise((done) => setTimeout(done, 5));
    // Let the page draw between frames, so that the user can cancel.
    await new Promise((done) => setTimeout(done, 0));
    if (this.failed) throw this.failed;
  }

  async end(): Promise<Blob> {
    await this.encoder.flush();
    this.encoder.close();
    if (this.failed) throw this.failed;
    return new Blob([webm(this.frames, this.width, this.height, this.rate)], {
      type: "video/webm",
    });
  }
  leave(): void {
    if (this.encoder.state !== "closed") this.encoder.close();
  }
}

// ---- Matroska: an element is an identifier, a size and its content

function joined(parts: Uint8Array[]): Uint8Array {
  const all = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    all.set(part, at);
    at += part.length;
  }
  return all;
}
/** The number in as many bytes as it needs, big-endian. */
function number(value: number): Uint8Array {
  const bytes: number[] = [];
  for (let rest = value; rest > 0 || bytes.length === 0; rest = Math.floor(rest / 256))
    bytes.unshift(rest % 256);
  return new Uint8Array(bytes);
}
function element(id: number, ...inside: Uint8Array[]): Uint8Array {
  const content = joined(inside),
    size = new Uint8Array(8);
  new DataView(size.buffer).setBigUint64(0, BigInt(content.length));
  size[0] = 1; // seven bytes follow
  return joined([number(id), size, content]);
}
const text = (value: string): Uint8Array => new TextEncoder().encode(value);
function real(value: number): Uint8Array {
  const bytes = new Uint8Array(8);
  new DataView(bytes.buffer).setFloat64(0, value);
  return bytes;
}

const EBML = 0x1a45dfa3,
  SEGMENT = 0x18538067,
  INFO = 0x1549a966,
  TRACKS = 0x1654ae6b,
  CLUSTER = 0x1f43b675,
  CUES = 0x1c53bb6b;

function webm(frames: Frame[], width: number, height: number, rate: number): Uint8Array {
  const head = element(
    EBML,
    element(0x4286, number(1)),
    element(0x42f7, number(1)),
    element(0x42f2, number(4)),
    element(0x42f3, number(8)),
    element(0x4282, text("webm")),
    element(0x4287, number(4)),
    element(0x4285, number(2)),
  );
  const info = element(
    INFO,
    element(0x2ad7b1, number(1e6)),
    element(0x4489, real((1000 * frames.length) / rate)),
    element(0x4d80, text("Kibori")),
    element(0x5741, text("Kibori")),
  );
  const track = element(
    0xae,
    element(0xd7, number(1)),
    element(0x73c5, number(1)),
    element(0x83, number(1)),
    element(0x86, text("V_VP8")),
    element(0x23e383, number(Math.round(1e9 / rate))),
    element(0xe0, element(0xb0, number(width)), element(0xba, number(height))),
  );
  const parts = [info, element(TRACKS, track)],
    cues: Uint8Array[] = [];
  let at = parts[0].length + parts[1].length;
  for (let first = 0; first < frames.length; ) {
    let end = first + 1;
    while (end < frames.length && !frames[end].key) end++;
    const from = frames[first].ms;
    const blocks = frames.slice(first, end).map(({ ms, key, data }) => {
      const place = new Uint8Array([0x81, (ms - from) >> 8, (ms - from) & 255, key ? 0x80 : 0]);
      return element(0xa3, place, data);
    });
    const cluster = element(CLUSTER, element(0xe7, number(from)), ...blocks);
    cues.push(
      element(
        0xbb,
        element(0xb3, number(from)),
        element(0xb7, element(0xf7, number(1)), element(0xf1, number(at))),
      ),
    );
    parts.push(cluster);
    at += cluster.length;
    first = end;
  }
  return joined([head, element(SEGMENT, ...parts, element(CUES, ...cues))]);
}
