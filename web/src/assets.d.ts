/** The build puts a style sheet into the script as text. */
declare module '*.css' {
  const text: string;
  export default text;
}

/** What web/tasks/package.mjs puts into the inlined script as text. */
declare module 'inside:*' {
  const text: string;
  export default text;
}
