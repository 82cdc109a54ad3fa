"""The program as pages hold it: its names stand for those of the sources one for one, and it says the same."""

import re
from collections import defaultdict
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpu_xform.gpu.device import GpuDevice
from gpu_xform.gpu.wgsl import installed_sources
from gpu_xform.web import program
from gpu_xform.web.scopes import PROPERTY, SCRIPT_WORDS, VARIABLE, WGSL_WORDS, NamedText, read_script, read_wgsl
from gpu_xform.web.short_names import SCRIPT, ShortNames, choose_names
from gpu_xform.web.short_program import KEPT_NAMES, make_program, shorten_markup, write_data
from gpu_xform.web.tokens import is_text, is_word, join_script, join_wgsl, split_script, split_wgsl

TEXTS: dict[str, NamedText] = {
    SCRIPT: read_script(split_script(program.join_scripts())),
    **{name: read_wgsl(split_wgsl(text)) for name, text in program.collect_wgsl(installed_sources()).items()},
}
NAMES = make_program().names
ALIAS = re.compile(r"\b(vec[234]|mat[234]x[234])([fiu])\b")


def list_plain(tokens: list[str]) -> list[str]:
    """Return tokens without commas and semicolons, numbers in one form."""
    plain = ["let" if part == "const" else part for part in tokens if part not in (",", ";")]
    return [str(float(part)) if re.fullmatch(r"\d+\.\d*|\.\d+", part) else part for part in plain]


# What the scripts use of the browser by its bare name.
GLOBALS = """
Array ArrayBuffer Boolean DataView Error Float32Array Float64Array GPUBuffer GPUBufferUsage GPUMapMode GPUTextureUsage
GPUTextureView ImageData Int32Array JSON Map Math Number Object OffscreenCanvas Path2D Promise ResizeObserver Set
TextDecoder URL URLSearchParams Uint32Array Uint8Array WeakMap clearTimeout console devicePixelRatio location navigator
performance requestAnimationFrame setTimeout
"""
BARE = frozenset(GLOBALS.split())


@pytest.mark.parametrize("key", TEXTS)
def test_short_names_lead_back_to_the_source(key: str) -> None:
    text = TEXTS[key]
    back = {new: old for old, new in NAMES.shared.items()}
    own_back = {
        scope: {new: old for old, new in names.items()} for (own, scope), names in NAMES.local.items() if own == key
    }
    restored = []
    for token, role, scope in zip(NAMES.rename(key, text), text.roles, text.scopes, strict=True):
        own = own_back.get(scope, {}) if role is VARIABLE else {}
        restored.append(token if role is None else own.get(token) or back.get(token, token))
    assert restored == list(text.tokens)


def test_no_two_names_become_one() -> None:
    everything = {token for text in TEXTS.values() for token in text.tokens if is_word(token)}
    assert len(set(NAMES.shared.values())) == len(NAMES.shared)
    staying = (everything | SCRIPT_WORDS | WGSL_WORDS | KEPT_NAMES | BARE) - NAMES.shared.keys()
    for key, text in TEXTS.items():
        others = defaultdict(set)
        for old, new, role, scope in zip(text.tokens, NAMES.rename(key, text), text.roles, text.scopes, strict=True):
            if role is not None and old not in NAMES.local.get((key, scope), {}):
                assert (new == old) == (old not in NAMES.shared)
                if role is not PROPERTY:
                    others[scope].add(new)
        for (own, scope), names in NAMES.local.items():
            if own == key:
                assert len(set(names.values())) == len(names)
                assert not set(names.values()) & (others[scope] | SCRIPT_WORDS | WGSL_WORDS | BARE)
    variables = {new for old, new in NAMES.shared.items() if len(new) > 1}
    assert not variables & staying


def test_what_scripts_do_not_declare_is_the_browsers() -> None:
    text = TEXTS[SCRIPT]
    found = set()
    for token, role, scope in zip(text.tokens, text.roles, text.scopes, strict=True):
        if role is VARIABLE and token not in text.shared | text.local.get(scope, set()):
            found.add(token)
    assert found == BARE
    assert not BARE & text.shared.union(*text.local.values())


@pytest.mark.parametrize("key", TEXTS)
def test_joined_tokens_are_those_that_were_split(key: str) -> None:
    join, split = (join_script, split_script) if key == SCRIPT else (join_wgsl, split_wgsl)
    joined = join(TEXTS[key].tokens)
    assert join(split(joined)) == joined
    said = split(joined if key == SCRIPT else ALIAS.sub(r"\1<\g<2>32>", joined))
    assert list_plain(said) == list_plain(list(TEXTS[key].tokens))


def test_names_are_read_where_they_stand() -> None:
    text = """
const SIDE = 4, other = ({ a, size: b = SIDE }, [c, , d]) => ({ a, b, long: c[d] = 1, call(e) { return e.a; } });
class Thing {
  constructor(kind) { this.kind = kind; table[kind] = /[/]"x/.test(`${kind} kind`); }
  get size() { return 3 / SIDE; }
}
"""
    named = read_script(split_script(text))
    assert named.shared == {"SIDE", "other", "Thing"}
    assert named.properties == {"a", "b", "long", "call", "kind", "size"}
    assert list(named.local.values()) == [{"a", "b", "c", "d", "e"}, {"kind"}]
    assert [token for token in named.tokens if is_text(token)] == ['/[/]"x/', "`${", "} kind`"]


def test_wgsl_is_read_as_scripts_are() -> None:
    text = "#import real\nstruct S { size: u32, }\n@group(0) @binding(0) var<uniform> s: S; override k: bool;\n"
    text += "fn f(@builtin(position) position: vec4<f32>) -> f32 { let x = position.x; return x * f32(s.size); }"
    named = read_wgsl(split_wgsl(text))
    assert (named.shared, named.properties) == ({"S", "s", "k", "f"}, {"size"})
    assert list(named.local.values()) == [{"position", "x"}]
    assert named.roles[named.tokens.index("position")] is None


def test_new_names_differ_from_those_that_stay() -> None:
    script = read_script(
        split_script("const thing = Aa, other = 1; function call(it, a) { return [it.b, other, it, a]; }")
    )
    names = choose_names(script, {}, {"b"}, {"Ab"})
    assert names.shared == {"other": "Ac", "call": "Ad", "thing": "Ae"}
    assert [*names.local.values()] == [{"it": "b", "a": "a"}]


def test_no_two_tokens_become_one() -> None:
    text = "const a = b + +c - -d; if (!/[/]/.test(e)) return f / g / h; else throw a?.5 : 1.0 + 0.5 + 10.0;"
    short = "let a=b+ +c- -d;if(!/[/]/.test(e))return f/g/h;else throw a?.5:1.0+.5+10.0;"
    assert join_script(split_script(text)) == short
    text = "// real\n#import real\nvar<private> a: vec3<f32> = vec3<f32>(1.0, 0.5, -10.0,); // three\n"
    assert join_wgsl(split_wgsl(text)) == "\n#import real\nvar<private>a:vec3f =vec3f(1.,.5,-10.);"


def test_scripts_of_others_have_the_names_of_the_page() -> None:
    names = ShortNames({"mesh": "Ab", "edges": "c", "nEdges": "d"}, {})
    text = "const {mesh} = page.layers[0], edges = mesh.edges; return [edges, mesh.nEdges, x.press];"
    assert names.rename_script(text) == "let{Ab}=page.layers[0],edges=Ab.c;return[edges,Ab.d,x.press];"
    assert names.rename_keys({"mesh": [{"nEdges": 3}], "kind": "mesh"}) == {"Ab": [{"d": 3}], "kind": "mesh"}


@pytest.mark.parametrize("stage", program.STAGES)
def test_other_browsers_compiler_takes_the_short_wgsl(stage: str, device: GpuDevice) -> None:
    made, lines = make_program(), []

    def include(number: str, seen: set[str]) -> None:
        seen.add(number)
        for line in made.files[number].splitlines():
            found = re.fullmatch(r"#import (\d+)", line)
            if found is None:
                lines.append(line)
            elif found[1] not in seen:
                include(found[1], seen)

    include(made.numbers[Path(installed_sources().stages[stage].file).stem], set())
    device.context.handle.create_shader_module(code="\n".join(lines))  # naga, as in Firefox


@given(st.one_of(st.floats(allow_nan=False, allow_infinity=False), st.integers(0, 255).map(lambda n: n / 255)))
def test_numbers_are_written_as_short_as_they_are(number: float) -> None:
    text = write_data([number])[1:-1]
    value = float(Fraction(text)) if "/" in text else float(text)
    assert value.hex() == number.hex()
    assert len(text) <= len(repr(number))


def test_data_is_written_as_scripts_have_it() -> None:
    data = {"size": [1.0, 0.25, -0.0], "2": {"a-b": "`", "c": "x"}, "d": None, "e": True}
    assert write_data(data) == '{size:[1,.25,-0],2:{"a-b":"`",c:`x`},d:null,e:true}'


def test_markup_keeps_its_words_and_places() -> None:
    text = "<p>$a</p>\n<style>\nb a:hover { margin: 0 1px; --c: $d }\n</style>\n"
    text += '<script type="module">\nconst at = 0.5;\n</script>\n'
    short = '<p>$a</p><style>b a:hover{margin:0 1px;--c:$d}</style><script type="module">let Aa=.5;</script>\n'
    assert shorten_markup(text) == short
