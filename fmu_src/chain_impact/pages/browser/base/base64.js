// Bytes and numbers from text in base64, as Python packs them for the pages.

/** Return the bytes of a text in base64. */
export function bytesIn(text) {
  return Uint8Array.from(atob(text), (sign) => sign.charCodeAt(0));
}

/** Return the numbers of 8 bytes in a text in base64, whose bytes are not compressed. */
export function numbersIn(text) {
  return new Float64Array(bytesIn(text).buffer);
}

/** Return the decompressed bytes of a text in base64. */
export async function decompressed(text) {
  const stream = new Blob([bytesIn(text)]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
