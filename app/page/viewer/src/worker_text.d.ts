// The built worker as a text; build.mjs supplies it.
declare module "worker-text" {
  const text: string;
  export default text;
}
