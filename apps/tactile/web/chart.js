// A dygraph in the colours of the page. dygraphs is a classic script and sets `Dygraph`; it draws on canvases.

import { colour, darkScheme } from "./dom.js";
import { shortNumber } from "./format.js";

const SERIES = ["series-1", "series-2", "series-3", "series-4"];

export function themed() {
  const ink = colour("ink-soft");
  return { axisLineColor: colour("line"), gridLineColor: colour("line"), axisLabelColor: ink };
}

export function seriesColours(count) {
  return SERIES.slice(0, count).map(colour);
}

/// Calls `redraw` when light becomes dark or back; returns what ends that.
export function onScheme(redraw) {
  darkScheme.addEventListener("change", redraw);
  return () => darkScheme.removeEventListener("change", redraw);
}

/// The legend's plug-in sets style attributes, which the content security policy refuses. The pages write the names of series themselves.
function withoutLegend() {
  const { Dygraph } = globalThis;
  Dygraph.PLUGINS = Dygraph.PLUGINS.filter((plugin) => plugin !== Dygraph.Plugins.Legend);
  return Dygraph;
}

/// A chart of {labels, rows, colours, …options of dygraphs} in `place`, which needs a height.
export function chart(place, { labels, rows, colours, ...options }) {
  const g = new (withoutLegend())(
    place,
    rows.length ? rows : [[0, ...labels.slice(1).map(() => (options.customBars ? [null, null, null] : null))]],
    {
      labels,
      colors: colours ?? seriesColours(labels.length - 1),
      interactionModel: {},
      highlightCircleSize: 0,
      rightGap: 8,
      axisLabelFontSize: 11,
      strokeWidth: 1.2,
      gridLineWidth: 0.5,
      animatedZooms: false,
      ...themed(),
      ...options,
      axes: {
        x: { ...options.axes?.x },
        y: { axisLabelWidth: 46, pixelsPerLabel: 22, axisLabelFormatter: (value) => shortNumber(value), ...options.axes?.y },
      },
    },
  );
  return g;
}
