// Numbers, units and times as text.

const RAISED = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };
const PREFIXES = { "-9": "n", "-6": "µ", "-3": "m", 3: "k", 6: "M", 9: "G" };
const PREFIXED = /^(m|s|N|Pa|J|W|V|A|C|Wb|Hz|F|H|ohm|N\*m|rad|rad\/s|m\/s)$/;

const MOST_DECIMALS = 6;

const raised = (exponent) => [...String(exponent)].map((c) => RAISED[c] ?? c).join("");

// A number in at most `digits` significant digits: 0.0125, −3.2·10⁻⁷, ∞.
export function number(value, digits = 4) {
  if (value == null || Number.isNaN(value)) return "–";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  const text = typed(value, digits);
  const [mantissa, exponent] = text.split("e");
  return (exponent ? `${mantissa}·10${raised(exponent)}` : mantissa).replace("-", "−");
}

// A number as it is typed: 0.0125, -3.2e-7.
export function typed(value, digits = 4) {
  if (value === 0 || !Number.isFinite(value)) return String(value);
  const size = Math.abs(value);
  if (size >= 1e-3 && size < 1e6) return String(Number(value.toPrecision(digits)));
  return value.toExponential(digits - 1).replace(/\.?0+e/, "e").replace("e+", "e");
}

// A value of a curve whose largest size is `largest`, on an axis from `low` to `high`: with the decimals that give
// that size four digits and its range on the axis two, so that it keeps its width. What is rounding on the axis is 0.
export function onAxis(value, largest, low, high) {
  if (!Number.isFinite(value) || !(largest > 0) || !(high > low)) return number(value);
  if (largest < 1e-7 * Math.max(Math.abs(low), Math.abs(high))) return "0";
  const digits = (size, count) => count - 1 - Math.floor(Math.log10(size));
  const decimals = Math.max(0, Math.min(MOST_DECIMALS, Math.max(digits(largest, 4), digits(high - low, 2))));
  return fixed(value, decimals);
}

// A number with a count of decimals.
export function fixed(value, decimals) {
  const text = value.toFixed(decimals);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−");
}

// A unit as it is printed: N·m, m/s², s⁻¹; of one that a user has named `name [unit]` its own part.
export function unitText(unit) {
  return (unit ?? "").replace(/\^(-?\d+)/g, (_, exponent) => raised(exponent)).replaceAll("*", "·").replace(/\bohm\b/g, "Ω");
}

// The exponent of ten, a multiple of 3, that the labels of an axis have in common: 0 for sizes from 0.01 to 10,000.
export function commonExponent(largest) {
  if (!(largest > 0) || (largest >= 0.01 && largest < 2e4)) return 0;
  return 3 * Math.floor(Math.log10(largest * (1 + 1e-9)) / 3);
}

// A unit with a power of ten: kN, mm, 10⁻⁶ m/s.
export function scaledUnit(unit, exponent) {
  if (exponent === 0) return unitText(unit);
  if (PREFIXED.test(unit) && PREFIXES[exponent]) return PREFIXES[exponent] + unitText(unit);
  return `10${raised(exponent)} ${unitText(unit)}`.trim();
}

// A power with its prefix.
export function watts(power) {
  const exponent = Math.max(-6, Math.min(6, 3 * Math.floor(Math.log10(Math.abs(power) || 1) / 3)));
  return `${number(power / 10 ** exponent, 3)} ${scaledUnit("W", exponent)}`;
}

// A time in a unit that suits a whole range of times.
export function timeUnit(range) {
  if (range >= 1 || range <= 0) return { unit: "s", factor: 1 };
  if (range >= 1e-3) return { unit: "ms", factor: 1e-3 };
  return { unit: "µs", factor: 1e-6 };
}
