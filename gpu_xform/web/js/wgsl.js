// WGSL sources: resolves `#import` lines as `gpu/wgsl.py` does, and finds the numbers of bindings.

const IMPORT = /^#import\s+(\w+)\s*(?:\/\/.*)?$/;
const BINDING = /@group\(0\) ?@binding\((\d+)\) ?var(?:<[\w, ]+>)? ?(\w+):/g;

// The text of a file of `files` (texts by name) without imports: each file in place of its first import, and that of the
// number type in place of `real`.
export function resolveImports(files, file, numberType = "f32") {
  const lines = [], included = new Set();
  const include = path => {
    for (const line of files[path].replace(/\n$/, "").split("\n")) {
      if (!line.startsWith("#")) {
        lines.push(line);
        continue;
      }
      const [, word] = IMPORT.exec(line) ?? [];
      const name = word === "real" ? `real_${numberType}` : word;
      if (!(name in files)) throw new Error(`${path}: no ${name} to import`);
      if (!included.has(name)) {
        included.add(name);
        include(name);
      }
    }
  };
  include(file);
  return lines.join("\n");
}

export function findBindings(code) {
  return Object.fromEntries([...code.matchAll(BINDING)].map(([, number, name]) => [name, Number(number)]));
}
