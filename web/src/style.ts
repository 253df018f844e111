// How a region is drawn, as pages and saved files say it.

/** The third word of a region's record where another absorbs it; the first is then that one's place: see src/style.rs. */
export const ABSORBED = 3 << 11;

/** A line along a region's boundary. */
export interface Outline {
  /** A CSS colour; black. */
  color?: string;
  /** 1, up to 127. */
  width?: number;
  /** What the width counts: CSS pixels of the screen, or pixels of the source. */
  unit?: 'screen' | 'source';
  side?: 'inside' | 'centre' | 'outside';
  /** Between regions of one group, 1 to 8191, there is none. */
  group?: number;
}

/** What repeats over a region. */
export interface Pattern {
  motif: 'rising' | 'falling' | 'horizontal' | 'vertical' | 'cross' | 'grid' | 'dots';
  /** A CSS colour; black. */
  color?: string;
  /** In pixels of the screen. */
  spacing?: 4 | 8 | 16 | 32;
}

/** How a region is drawn. What is left out is as the file has it. */
export interface Style {
  /** A CSS colour. */
  color?: string;
  /** 0 to 1. */
  opacity?: number;
  /** `false`: the background shows. `'absorbed'`: it is drawn as the neighbour with which it has the longest boundary. */
  visible?: boolean | 'absorbed';
  /** Lighter than it would be. */
  highlight?: boolean;
  outline?: Outline;
  pattern?: Pattern;
}

/** Styles as they are saved: those for all regions, for all of a colour (`#rrggbb`), and for single ones, by number. */
export interface StyleSheet {
  all?: Style;
  colors?: Record<string, Style>;
  regions?: Record<string, Style>;
}
