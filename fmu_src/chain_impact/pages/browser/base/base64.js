// Bytes and numbers from text in base64, as Python packs them for the pages.

/** Return the bytes of a text in base64. */
export function bytesIn(text) {
  const signs = atob(text);
  const bytes = new Uint8Array(signs.length);
  for (let k = 0; k < signs.length; k += 1) bytes[k] = signs.charCodeAt(k);
  return bytes;
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
