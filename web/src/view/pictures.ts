// SPDX-License-Identifier: MIT
// Pictures of the solid for files, in any size and without the tool and the marks.
import * as THREE from "three";
import type { Cameras, Size } from "./cameras";
import type { Painter } from "./painter";

/** The properties of a picture. Background: a CSS colour, or null for transparent. */
export interface Capture extends Size {
  background: string | null;
}

function surfaceOf({ width, height, background }: Capture): {
  canvas: HTMLCanvasElement;
  context: CanvasRenderingContext2D;
} {
  const canvas = document.createElement("canvas");
  canvas.width = width;
  canvas.height = height;
  const context = canvas.getContext("2d")!;
  if (background) {
    context.fillStyle = background;
    context.fillRect(0, 0, width, height);
  }
  return { canvas, context };
}

export class Pictures {
  constructor(
    private canvas: HTMLCanvasElement,
    private painter: Painter,
    private cameras: Cameras,
    /** Objects to leave out. */
    private hidden: THREE.Object3D[],
  ) {}

  /** Takes a picture without the tool. Null if the browser cannot encode it. */
  async capture(of: Capture): Promise<Blob | null> {
    let picture: Promise<Blob | null> | null = null;
    await this.sized(of, async () => {
      const { canvas, context } = surfaceOf(of);
      this.draw();
      context.drawImage(this.canvas, 0, 0);
      picture = new Promise((done) => canvas.toBlob(done, "image/png"));
    });
    return picture;
  }

  /**
   * Takes `count` pictures of one turn about the upright axis. Calls use() with each before drawing
   * the next. use() returns whether to continue.
   */
  async turntable(
    of: Capture,
    count: number,
    use: (picture: HTMLCanvasElement, index: number) => Promise<boolean>,
  ): Promise<void> {
    await this.sized(of, () => {
      const { canvas, context } = surfaceOf(of);
      return this.cameras.aroundOnce(count, (i) => {
        this.draw();
        if (of.background) context.fillRect(0, 0, of.width, of.height);
        else context.clearRect(0, 0, of.width, of.height);
        context.drawImage(this.canvas, 0, 0);
        return use(canvas, i);
      });
    });
  }

  /** Draws at full quality. */
  private draw(): void {
    const were = this.hidden.map((object) => object.visible);
    for (const object of this.hidden) object.visible = false;
    const { ghostly } = this.painter;
    this.painter.ghostly = false;
    this.painter.render(true);
    this.painter.ghostly = ghostly;
    this.hidden.forEach((object, i) => (object.visible = were[i]));
  }
  /** Calls use() while the canvas has another size. */
  private async sized(of: Size, use: () => Promise<void>): Promise<void> {
    this.cameras.size = { width: of.width, height: of.height };
    this.canvas.style.objectFit = "contain";
    this.cameras.controls.enabled = false;
    try {
      await use();
    } finally {
      this.cameras.size = null;
      this.canvas.style.objectFit = "";
      this.cameras.controls.enabled = true;
      this.painter.render(true);
    }
  }
}
