// @ts-check
// Files of the page, for the page and its workers.

/** A file; rejects with the reason or its name when it is missing. @param {string | URL} address */
export async function fetched(address) {
  const response = await fetch(address);
  // The server says why it could not make a file.
  const reason = response.status === 500 ? await response.text() : "";
  if (reason) throw new Error(reason);
  if (!response.ok || !response.body) throw new Error(`${String(address).split("/").pop()} is missing: ${response.status}`);
  return response;
}

/** A file that is stored deflated. @param {string | URL} address @returns {Promise<ArrayBuffer>} */
export async function inflated(address) {
  const { body } = await fetched(address);
  return new Response(body?.pipeThrough(new DecompressionStream("deflate-raw"))).arrayBuffer();
}
