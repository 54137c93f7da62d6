// Reads what was drawn, without waiting for the graphics card: a browser answers such a read only after all frames that
// were asked for before it, so that it comes when these are done.
import type { WebGLRenderTarget } from "three";
import type { Viewport } from "./viewport";

const POLL_MS = 6;

/** The pixels of the target that was drawn to last, into an array of its type. */
export async function readBack(viewport: Viewport, target: WebGLRenderTarget, into: Float32Array | Uint8Array): Promise<void> {
  const gl = viewport.renderer.getContext() as WebGL2RenderingContext;
  const buffer = gl.createBuffer();
  viewport.renderer.setRenderTarget(target);
  gl.bindBuffer(gl.PIXEL_PACK_BUFFER, buffer);
  gl.bufferData(gl.PIXEL_PACK_BUFFER, into.byteLength, gl.STREAM_READ);
  const type = into instanceof Float32Array ? gl.FLOAT : gl.UNSIGNED_BYTE;
  gl.readPixels(0, 0, target.width, target.height, gl.RGBA, type, 0);
  gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
  viewport.renderer.setRenderTarget(null);
  await quiet(viewport, gl);
  gl.bindBuffer(gl.PIXEL_PACK_BUFFER, buffer);
  gl.getBufferSubData(gl.PIXEL_PACK_BUFFER, 0, into);
  gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
  gl.deleteBuffer(buffer);
}

/** Waits until all frames that were asked for are done: while the view moves nothing is read. */
async function quiet(viewport: Viewport, gl: WebGL2RenderingContext): Promise<void> {
  for (;;) {
    const { framesDrawn } = viewport;
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0)!;
    gl.flush();
    while (gl.clientWaitSync(fence, 0, 0) === gl.TIMEOUT_EXPIRED) await pause();
    gl.deleteSync(fence);
    if (framesDrawn === viewport.framesDrawn && !viewport.isAsked) return;
    await pause();
  }
}

const pause = (): Promise<void> => new Promise((resolve) => setTimeout(resolve, POLL_MS));
