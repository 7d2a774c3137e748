"""Absurd texts get a diagnostic, in bounded time and without a traceback."""

import re

import pytest

from bgc.diagnostics.catalogue.files import file_missing
from bgc.diagnostics.collection import MAX_ERRORS, Report
from bgc.diagnostics.diagnostic import BgError
from bgc.elaboration.elaborate import elaborate
from bgc.elaboration.instances import instantiate
from bgc.resolution.resolve import load, load_text

PARTS = "s : Se(e = a); r : R(1); s -> r;"
DOUBLING = "function f0(x) = x + x;" + "".join(
    f"function f{k}(x) = f{k - 1}(x) + f{k - 1}(2*x);" for k in range(1, 40)
)
ABSURD = {
    "BG119": ["let a = 1e400;", "let a = 1e99999999999;", f"let a = {'9' * 5000};"],
    "BG333": ["let a = 1e-400;", "let a = 10^1000000000;", "let a = 2^(2^(2^(2^30)));"],
    "BG317": [
        "let a = sum(zeros(100000, 100000));",
        "let a = 1; w : Se[5000](e = 1); c : C[5000](1); w -> c;",
    ],
    "BG118": [
        f"let a = {'(' * 10000}1{')' * 10000};",
        f"let a = {'[' * 10000}1{']' * 10000};",
        f"let a = {'-' * 20000}1;",
        f"let a = 1; {'if 1 > 0 { ' * 5000} {'}' * 5000}",
    ],
    "BG331": [
        "let a = 1; w : Se[100000000](e = 1); c : R(1); w -> c;",
        "let a = 1; w : Se[-3](e = 1); c : R(1); w -> c;",
        "let a = 1; for i in 1..1000000000 { x[i] : R(1); }",
        "let v = [1, 2]; let a = v[1e30];",
    ],
    "BG418": ["let a = 1; for i in 1..30000 { for j in 1..30000 { } }"],
    "BG120": [f"param {'a' * 100_001} = 1;"],
    "BG121": ["let a = 1;" + "\n".join(f"let a{k} = b{k};" for k in range(2000))],
    "BG335": ["let a = log(-1);"],
    None: [  # long, but not absurd
        f"let a = {'*'.join(['1'] * 3000)}; unknown y = 0; equation a = {'-'.join(['y'] * 3000)};",
        f"let a = 0; x : R {{ e = {' + '.join(['0.1*f'] * 3000)}; }} j : J1; j -> x;",
        f"let a = 0; {'if ' + ' and '.join(['1 > 0'] * 3000)} {{ }}",
        "let a = 1; let a0 = time;" + "\n".join(f"let a{k} = a{k - 1}^2;" for k in range(1, 2000)),
    ],
}
CASES = [(code, text) for code, texts in ABSURD.items() for text in texts]


def codes_of(text: str) -> list[str]:
    try:
        elaborate(load_text(text, "absurd.bg"))
    except BgError as err:
        return [d.code for d in err.diagnostics]
    return []


@pytest.mark.parametrize(("code", "text"), CASES, ids=[f"{c}-{t[:30]}" for c, t in CASES])
def test_absurd_text(code, text):
    found = codes_of(f"model M {{ {text} {PARTS} }}")
    assert (code in found) if code else found == []
    assert len(found) <= MAX_ERRORS + 1


def test_a_long_sum_is_that_of_its_terms():
    terms = "".join(f"{'+-'[k % 2]} {k}\n" for k in range(1, 5001))
    graph = elaborate(load_text(f"model M {{ param p = 0 {terms}; state x = p; der(x) = -x; }}"))
    assert graph.dag.value(graph.parameters[0].value) == 2500


def test_a_full_report_ends_the_pass():
    report, entered = Report(), 0
    with pytest.raises(BgError) as caught:
        for k in range(1000):
            entered = k
            with report.collecting():
                raise BgError([file_missing(f"{k}.bg")])
    assert entered == MAX_ERRORS and len(caught.value.diagnostics) == MAX_ERRORS + 1


def test_functions_that_double_are_evaluated_once_each():
    assert codes_of(f"{DOUBLING} model M {{ let a = f39(time); {PARTS} }}") == []


def test_parts_that_double_are_too_many_and_told_once(monkeypatch):
    monkeypatch.setattr(instantiate, "MAX_PARTS", 1000)
    text = "model L0 { port p; r : R(1); p -> r; }" + "".join(
        f"model L{k} {{ port p; j : J1; a : L{k - 1}; b : L{k - 1}; p -> j -> a, b; }}"
        for k in range(1, 40)
    )
    assert codes_of(f"{text} model M {{ s : Se(e = 1); x : L39; s -> x; }}") == ["BG418"]


@pytest.mark.parametrize(
    "text",
    [b"model M {\0}", "model M { }".encode("utf-16"), b"model M { param \xe9 = 1; }", b"{" * 20000],
)
def test_bytes_that_are_no_model(tmp_path, text):
    path = tmp_path / "bytes.bg"
    path.write_bytes(text)
    with pytest.raises(BgError) as caught:
        load(path)
    assert all(re.fullmatch(r"BG[01]\d\d", d.code) and d.help for d in caught.value.diagnostics)


@pytest.mark.parametrize("ends", [b"\n", b"\r\n", b"\r"])
@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"])
def test_line_ends_and_marks_of_other_systems(tmp_path, ends, mark):
    path = tmp_path / "ends.bg"
    text = f"model M {{\n let a = 1;\n {PARTS}\n}}\n"
    path.write_bytes(mark + text.encode().replace(b"\n", ends))
    assert elaborate(load(path)).elements
