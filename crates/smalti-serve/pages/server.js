// @ts-check
// Requests to the server of this page. Every path is relative, so that it stays below the token of the address.

/** @typedef {{ experiment: string, pairs: number, training: number, break_every: number, rows: number, cols: number }} About */
/** @typedef {{ observer: number, number: number, pairs: number, training: number, done: boolean, rows: number, cols: number }} Pair */
/** @typedef {{ device_pixel_ratio: number, screen_px: [number, number], px_per_mm?: number, gamma?: number }} Display */
/** @typedef {"left" | "right"} Side */

/** The server has refused a request; `status` says why. */
export class Refused extends Error {
  /** @param {number} status @param {string} message */
  constructor(status, message) {
    super(message);
    this.status = status;
  }
}

/** Milliseconds between attempts while the server is not available. */
const RETRY_MS = 1000;

/**
 * Sends a request, again and again while the server is away or fails, for example because its disk is full. `tell` learns whether it is so.
 * @param {string} path @param {RequestInit} options @param {(away: boolean) => void} tell
 * @returns {Promise<Response>}
 */
async function send(path, options, tell) {
  for (;;) {
    let response;
    try {
      response = await fetch(path, { ...options, cache: "no-store", redirect: "error" });
    } catch { /* The server is away. */ }
    if (!response || response.status >= 500) {
      tell(true);
      await new Promise((resolve) => { setTimeout(resolve, RETRY_MS); });
      continue;
    }
    tell(false);
    if (!response.ok) throw new Refused(response.status, await response.text());
    return response;
  }
}

export class Server {
  /** @param {(away: boolean) => void} tell */
  constructor(tell) {
    this.tell = tell;
    this.secret = "";
  }

  /** @param {string} path @param {unknown} [body] @returns {Promise<any>} */
  async json(path, body) {
    /** @type {Record<string, string>} */
    const headers = this.secret ? { Authorization: `Bearer ${this.secret}` } : {};
    const options = body === undefined ? { headers } : {
      method: "POST", headers: { ...headers, "Content-Type": "application/json" }, body: JSON.stringify(body),
    };
    return (await send(path, options, this.tell)).json();
  }

  /** @returns {Promise<About>} */
  about() { return this.json("api/experiment"); }

  /**
   * Takes part as the observer who has a secret. A request that is sent again, since its reply was lost, makes no second observer.
   * @param {string} secret @param {Display} display @returns {Promise<{ number: number }>}
   */
  join(secret, display) { return this.json("api/observers", { consent: true, secret, display }); }

  /** @returns {Promise<Pair>} */
  pair() { return this.json("api/pair"); }

  /** @param {number} number @param {Side} choice @param {number} responseMs @returns {Promise<Pair>} */
  answer(number, choice, responseMs) {
    return this.json("api/answer", { number, choice, response_ms: Math.round(responseMs) });
  }

  /** @param {number} number @param {"left" | "right" | "reference"} which @returns {Promise<Blob>} */
  async picture(number, which) {
    const headers = { Authorization: `Bearer ${this.secret}` };
    return (await send(`api/picture/${number}/${which}`, { headers }, this.tell)).blob();
  }
}
