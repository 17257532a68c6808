// Figures with 95 % intervals, compared. No document here.

/// What a comparison of two figures can say: "higher", "lower", or "no clear difference" where the intervals overlap; "" without intervals.
export function comparison(a, b) {
  if (!known(a) || !known(b)) return "";
  if (a.low > b.high) return "first is higher";
  if (a.high < b.low) return "first is lower";
  return "intervals overlap";
}

function known(figure) {
  return figure && [figure.low, figure.value, figure.high].every((value) => typeof value === "number");
}

/// The figures of a model that evaluation gives, in the order they are shown: [key, words, unit].
export const MODEL_FIGURES = [
  ["accuracy", "Accuracy", "share"],
  ["press_delay_ms", "Press delay", "ms"],
  ["slip_delay_ms", "Slip delay", "ms"],
  ["missed.press", "Missed presses", "share"],
  ["missed.slip", "Missed slips", "share"],
  ["false_alarms_per_min", "False alarms", "1/min"],
];

/// The figure of an evaluation with a key such as "missed.press"; null if it has none.
export function figureOf(evaluation, key) {
  return key.split(".").reduce((part, name) => part?.[name] ?? null, evaluation ?? null);
}

/// Rows for two studies side by side: each label that one of them has, in the order of the first.
export function sideBySide(first, second) {
  const rows = first.map((figure) => ({
    label: figure.label,
    unit: figure.unit,
    first: figure,
    second: second.find((f) => f.label === figure.label) ?? null,
  }));
  const labels = new Set(first.map((figure) => figure.label));
  return [
    ...rows,
    ...second
      .filter((figure) => !labels.has(figure.label))
      .map((figure) => ({ label: figure.label, unit: figure.unit, first: null, second: figure })),
  ];
}

/// Settings as rows [name, value], with nested names joined: {train: {epochs: 40}} gives ["train.epochs", "40"].
export function settingRows(settings, before = "") {
  return Object.entries(settings ?? {}).flatMap(([name, value]) =>
    value !== null && typeof value === "object" && !Array.isArray(value)
      ? settingRows(value, `${before}${name}.`)
      : [[before + name, Array.isArray(value) ? value.join(", ") : String(value)]],
  );
}

/// The columns of a training history that are charts: losses, and shares from 0 to 1.
export function curvesOf(history) {
  const columns = Object.keys(history[0] ?? {}).filter((name) => history.some((row) => typeof row[name] === "number"));
  const of = (word) => columns.filter((name) => name.includes(word));
  return [
    { title: "Loss", names: of("loss") },
    { title: "Accuracy", names: of("accuracy") },
  ]
    .filter((group) => group.names.length)
    .map((group) => ({ ...group, rows: history.map((row, i) => [row.epoch ?? i + 1, ...group.names.map((name) => row[name] ?? null)]) }));
}
