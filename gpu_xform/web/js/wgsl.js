// WGSL sources: resolves `#import` lines as `gpu/wgsl.py` does, and finds the numbers of bindings.

const IMPORT = /^#import\s+(\w+)\s*(?:\/\/.*)?$/;
const BINDING = /^@group\(0\) ?@binding\((\d+)\) ?var(?:<[\w, ]+>)? ?(\w+):/gm;

// The text of a file of `files` (texts by path) without imports: each `shared/name.wgsl` in place of its first import,
// and that of the number type in place of `real`.
export function resolveImports(files, file, numberType = "f32") {
  const lines = [], included = new Set();
  const include = path => {
    for (const line of files[path].replace(/\n$/, "").split("\n")) {
      if (!line.startsWith("#")) {
        lines.push(line);
        continue;
      }
      const [, word] = IMPORT.exec(line) ?? [];
      const name = word === "real" ? `real_${numberType}` : word, imported = `shared/${name}.wgsl`;
      if (!(imported in files)) throw new Error(`${path}: no ${imported} to import`);
      if (!included.has(name)) {
        included.add(name);
        include(imported);
      }
    }
  };
  include(file);
  return lines.join("\n");
}

export function findBindings(code) {
  return Object.fromEntries([...code.matchAll(BINDING)].map(([, number, name]) => [name, Number(number)]));
}
