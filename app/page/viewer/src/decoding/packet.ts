// The container that app/page/packet.py writes: gunzip, then `RZPG`, a JSON header, and byte sections.

export interface Packet<Header> {
  header: Header;
  sections: Map<string, Uint8Array>;
}

export async function gunzip(packed: Uint8Array): Promise<Uint8Array> {
  const stream = new Blob([packed as BlobPart]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

export function parsePacket<Header>(data: Uint8Array): Packet<Header> {
  if (data.length < 8 || String.fromCharCode(...data.subarray(0, 4)) !== "RZPG") {
    throw new Error("this is no data of a map");
  }
  let start = 8 + new DataView(data.buffer, data.byteOffset).getUint32(4, true);
  const header = JSON.parse(new TextDecoder().decode(data.subarray(8, start)));
  const sections = new Map<string, Uint8Array>();
  for (const entry of header.sections as { name: string; bytes: number }[]) {
    sections.set(entry.name, data.subarray(start, start + entry.bytes));
    start += entry.bytes;
  }
  return { header, sections };
}

export function base64Bytes(text: string): Uint8Array {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

/** Whole numbers of byte planes, low bytes first; as many planes as there are bytes for `count` numbers. */
export function joinPlanes(section: Uint8Array, count: number): Int32Array {
  const numbers = new Int32Array(count);
  const planes = count ? section.length / count : 0;
  for (let plane = 0; plane < planes; plane++) {
    const offset = plane * count;
    for (let i = 0; i < count; i++) numbers[i] |= section[offset + i] << (8 * plane);
  }
  return numbers;
}

/** 0, 1, 2, 3, 4 become 0, -1, 1, -2, 2, in place. */
export function unzigzag(numbers: Int32Array): Int32Array {
  for (let i = 0; i < numbers.length; i++) numbers[i] = (numbers[i] >>> 1) ^ -(numbers[i] & 1);
  return numbers;
}

export function bit(bits: Uint8Array, index: number): number {
  return (bits[index >> 3] >> (index & 7)) & 1;
}
