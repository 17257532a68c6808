// Numbers and times as people read them. All times in the page are whole microseconds after the recording's first event.

const MS = 1000;
const SECOND = 1_000_000;

/// Seconds, with as many decimals as a view of this length needs: "1.23", "1.2345", "1.234567".
export function secondsText(us, span_us = 0) {
  if (us === null || us === undefined) return "–";
  return (us / SECOND).toFixed(decimalsFor(span_us)) + " s";
}

/// Decimals of a second that still differ on a screen that shows `span_us`; 6 where no span is given, as the API has them.
export function decimalsFor(span_us) {
  if (!span_us) return 6;
  if (span_us > 20 * SECOND) return 2;
  if (span_us > 1 * SECOND) return 3;
  if (span_us > 100 * MS) return 4;
  if (span_us > 10 * MS) return 5;
  return 6;
}

/// "1.2345" or "1.2345 s" to microseconds; null if it is no number.
export function secondsFrom(text) {
  const words = String(text).trim().replace(/\s*s$/, "").replace(",", ".");
  if (!/^-?\d+(\.\d*)?$|^-?\.\d+$/.test(words)) return null;
  return Math.round(Number(words) * SECOND);
}

/// A length: "850 µs", "12.5 ms", "2.70 s", "10 min 02 s".
export function lengthText(us) {
  if (us === null || us === undefined) return "–";
  const size = Math.abs(us);
  if (size < MS) return `${us} µs`;
  if (size < SECOND) return `${Number((us / MS).toFixed(size < 10 * MS ? 2 : 1))} ms`;
  if (size < 60 * SECOND) return `${(us / SECOND).toFixed(2)} s`;
  const seconds = Math.round(us / SECOND);
  return `${Math.floor(seconds / 60)} min ${String(seconds % 60).padStart(2, "0")} s`;
}

/// The 95 % interval around a time: "±1.0 ms", or "−0.6 … +2.1 ms" if the sides differ by more than a tenth.
export function withinText(low_us, at_us, high_us) {
  const below = (at_us - low_us) / MS;
  const above = (high_us - at_us) / MS;
  const size = Math.max(below, above);
  if (!(size > 0)) return "exact";
  const decimals = size < 10 ? 1 : 0;
  if (Math.abs(below - above) <= 0.1 * size) return `±${((below + above) / 2).toFixed(decimals)} ms`;
  return `−${below.toFixed(decimals)} … +${above.toFixed(decimals)} ms`;
}

/// 1234567 as "1.23 M".
export function countText(value) {
  if (value === null || value === undefined) return "–";
  const size = Math.abs(value);
  if (size >= 1e9) return `${(value / 1e9).toFixed(2)} G`;
  if (size >= 1e6) return `${(value / 1e6).toFixed(2)} M`;
  if (size >= 1e4) return `${(value / 1e3).toFixed(0)} k`;
  if (size >= 1e3) return `${(value / 1e3).toFixed(1)} k`;
  return String(Math.round(value));
}

/// A number with three significant digits, without an exponent.
export function shortNumber(value) {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  const size = Math.abs(value);
  if (size === 0) return "0";
  if (size >= 10_000) return countText(value);
  if (size >= 100) return value.toFixed(0);
  if (size >= 10) return value.toFixed(1);
  if (size >= 1) return value.toFixed(2);
  if (size >= 0.0005) return value.toFixed(3);
  return value.toExponential(1);
}

/// A value of a signal: as `shortNumber`, but what is below 0.0005 is 0.000.
export function valueText(value) {
  return value !== null && value !== undefined && value !== 0 && Math.abs(value) < 0.0005 ? "0.000" : shortNumber(value);
}

/// "m/s2" as "m/s²".
export function unitText(unit) {
  return unit.replace(/2$/, "²").replace(/3$/, "³");
}

/// A figure with its 95 % interval: "24.0 ms (20.0 to 29.0)". The unit "share", from 0 to 1, is shown as %.
export function figureText(figure, unit = "") {
  if (!figure || figure.value === null || figure.value === undefined) return "–";
  const text = (value) => (unit === "share" ? (100 * value).toFixed(1) : unit === "%" ? value.toFixed(1) : shortNumber(value));
  const shown = unit === "share" ? "%" : unit;
  const value = text(figure.value) + (shown ? ` ${shown}` : "");
  if (figure.low === null || figure.low === undefined || figure.high === null || figure.high === undefined) return value;
  return `${value} (${text(figure.low)} to ${text(figure.high)})`;
}

/// "2026-11-25T14:30:01.123Z" as "2026-11-25 14:30:01 UTC".
export function whenText(when) {
  const parts = /^(\d{4}-\d\d-\d\d)T(\d\d:\d\d:\d\d)/.exec(when ?? "");
  return parts ? `${parts[1]} ${parts[2]} UTC` : (when ?? "–");
}

/// "1 run", "2 runs".
export function counted(count, word, many = word + "s") {
  return `${count} ${count === 1 ? word : many}`;
}

/// How exactly the clocks of a run are known: ["robot ±0.8 ms"].
export function clockTexts(clocks) {
  const texts = ["robot", "video"].flatMap((device) => {
    const within = clocks?.[`${device}_interval_ms`] ?? null;
    return within === null ? [] : [`${device} ±${shortNumber(within)} ms`];
  });
  return texts.length ? texts : ["–"];
}
