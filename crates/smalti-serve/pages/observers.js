// @ts-check
// Who judges in this window. A window keeps its observer until it is closed. The browser also keeps all observers who began in it and have not
// finished, so that they can continue after a crash. Another window continues as one of them only if somebody chooses so.

/** @param {() => Storage} store @param {string} key @returns {string | null} */
export function kept(store, key) {
  // Storage may be forbidden; then nothing is kept.
  try { return store().getItem(key); } catch { return null; }
}

/** @param {() => Storage} store @param {string} key @param {string | null} value */
export function keep(store, key, value) {
  try {
    if (value === null) store().removeItem(key);
    else store().setItem(key, value);
  } catch { /* nothing is kept */ }
}

const ofBrowser = () => localStorage;
const ofWindow = () => sessionStorage;
/** Milliseconds within which a page that is being left releases its observer. */
const LEAVING_MS = 2000;
const SECRET = /^[0-9a-f]{32}$/;

/** A new secret: 128 random bits as hexadecimal digits. */
export function newSecret() {
  return Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join("");
}

export class Observers {
  /** @param {string} experiment */
  constructor(experiment) {
    this.key = `smalti-observer-${experiment}`;
  }

  /** The secret of the observer in this window. */
  current() {
    const secret = kept(ofWindow, this.key);
    return secret !== null && SECRET.test(secret) ? secret : null;
  }

  /** The secrets of all observers who began in this browser and have not finished. Each has a key, since windows write at the same time. */
  unfinished() {
    try {
      const ours = Object.keys(localStorage).filter((key) => key.startsWith(`${this.key}-`));
      return ours.map((key) => key.slice(this.key.length + 1)).filter((secret) => SECRET.test(secret));
    } catch {
      return [];
    }
  }

  /** Makes an observer that of this window. @param {string} secret */
  begin(secret) {
    keep(ofWindow, this.key, secret);
    keep(ofBrowser, `${this.key}-${secret}`, "");
  }

  /** This window has no observer any more. */
  leave() { keep(ofWindow, this.key, null); }

  /** An observer has finished, or is not known to the server. @param {string} secret */
  finish(secret) { keep(ofBrowser, `${this.key}-${secret}`, null); }

  /**
   * Takes an observer for this window until it is closed; false where another window has it, such as the original of a duplicated one.
   * @param {string} secret @param {boolean} isReload Whether the page before may still be about to release it.
   * @returns {Promise<boolean>}
   */
  take(secret, isReload) {
    if (!navigator.locks) return Promise.resolve(true);
    return new Promise((resolve) => {
      const options = isReload ? { signal: AbortSignal.timeout(LEAVING_MS) } : { ifAvailable: true };
      navigator.locks.request(`${this.key}-${secret}`, options, (lock) => {
        resolve(lock !== null);
        // Kept for as long as the page is open.
        return lock === null ? null : new Promise(() => {});
      }).catch(() => resolve(false));
    });
  }

  /** Whether no window has an observer. @param {string} secret @returns {Promise<boolean>} */
  async isFree(secret) {
    if (!navigator.locks) return true;
    return navigator.locks.request(`${this.key}-${secret}`, { ifAvailable: true }, (lock) => lock !== null);
  }
}
