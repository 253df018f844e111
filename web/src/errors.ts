/** What went wrong, by who can do something about it. */
export type ErrorKind =
  | 'network'
  | 'http'
  | 'aborted'
  | 'changed'
  | 'malformed'
  | 'unsupported'
  | 'limit'
  | 'gpu';

const KINDS: readonly string[] = [
  'network',
  'http',
  'aborted',
  'changed',
  'malformed',
  'unsupported',
  'limit',
  'gpu',
];

export class ViewerError extends Error {
  readonly kind: ErrorKind;
  /** It may go well when it is tried again. */
  readonly passing: boolean;

  constructor(kind: ErrorKind, message: string, cause?: unknown, passing = false) {
    super(message, { cause });
    this.name = 'ViewerError';
    this.kind = kind;
    this.passing = passing;
  }
}

/** Rust says the kind in an error's name; anything else that was thrown gets the kind of the step it broke. */
export function viewerError(cause: unknown, step: ErrorKind): ViewerError {
  if (cause instanceof ViewerError) return cause;
  if (!(cause instanceof Error)) return new ViewerError(step, String(cause), cause);
  const kind = KINDS.includes(cause.name) ? (cause.name as ErrorKind) : step;
  return new ViewerError(kind, cause.message, cause);
}
