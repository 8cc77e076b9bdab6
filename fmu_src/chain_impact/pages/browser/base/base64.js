// The reader of bytes that `packed` of `explore.py` has compressed, and of numbers in base64.

/** Return the bytes of a text in base64. */
export function bytesIn(text) {
  return Uint8Array.from(atob(text), (sign) => sign.charCodeAt(0));
}

/** Return the numbers in a text that is not compressed. */
export function numbersIn(text) {
  return new Float64Array(bytesIn(text).buffer);
}

/** Return the bytes of a compressed text. */
export async function unpacked(text) {
  const stream = new Blob([bytesIn(text)]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
