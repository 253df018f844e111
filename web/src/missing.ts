/** A module that is not there leaves the viewer without what it does. */
export function missing(cause: unknown): undefined {
  console.warn(cause);
}
