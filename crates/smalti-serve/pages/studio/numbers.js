// @ts-check
// Numbers as they are written on the page.

/** A number with a minus sign, but zero without a sign. @param {number} value @param {number} digits */
export function text(value, digits) {
  const shown = value.toFixed(digits);
  return shown.replace("-", Number(shown) === 0 ? "" : "−");
}

/** A change with its sign. @param {number} value @param {number} digits */
export function signed(value, digits) {
  const amount = text(Math.abs(value), digits);
  return `${Number(amount) === 0 ? "±" : value < 0 ? "−" : "+"}${amount}`;
}

/** A number of things, in words. @param {number} count @param {string} thing In the singular. */
export const counted = (count, thing) => `${count} ${thing}${count === 1 ? "" : "s"}`;
