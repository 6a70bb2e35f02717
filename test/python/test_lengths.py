"""The length of our functions and files: a function has at most 40 lines, and a file of more than 450 says why. Each C++, Python and
JavaScript file of the tree counts."""

import ast
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[2]
MOST_OF_FUNCTION, MOST_OF_FILE = 40, 450  # lines
NO_CODE = re.compile(r'R"(\w*)\(.*?\)\1"|//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'(?!\w)|^[ \t]*#(?:[^\n]*\\\n)*[^\n]*', re.S | re.M)
NO_JAVASCRIPT = re.compile(r"//[^\n]*|/\*.*?\*/|`(?:\\.|[^`\\])*`|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])*'", re.S)
CONTROL = re.compile(r"\s*(?:else\s+)?(?:if|for|while|switch|catch)\b")
FOR = re.compile(r"\bfor\s*\((?:[^()]|\([^()]*\))*\)")
SCOPE = re.compile(r"\s*(?:template\s*<.*>\s*)?(?:inline\s+)?(?:namespace|class|struct|union|enum|extern)\b", re.S)


def cpp_functions(text):
    """(first line, lines) of each outermost function's body: the braces that follow parentheses and are in no function."""
    code = NO_CODE.sub(lambda match: re.sub(r"[^\n]", " ", match[0]), text)
    is_inside, opened, begin = [False], [], 0
    for brace in re.finditer(r"[{};]", code):
        head, line = code[begin : brace.start()], code.count("\n", 0, brace.start()) + 1
        begin = brace.end()
        if brace[0] == "{":
            starts = not is_inside[-1] and not SCOPE.match(head) and ")" in head and head.count("(") == head.count(")")
            opened.append(line if starts else 0)
            is_inside.append(is_inside[-1] or not SCOPE.match(head))
        elif brace[0] == "}":
            is_inside.pop()
            first = opened.pop()
            if first:
                yield first, line - first + 1


def javascript_functions(text):
    """(first line, lines) of each outermost function's body: the braces after parentheses or an arrow that are in no function.
    No template has a template within it, and no regular expression a quote or a brace."""
    code = NO_JAVASCRIPT.sub(lambda match: re.sub(r"[^\n]", " ", match[0]), text)
    code = FOR.sub(lambda match: match[0].replace(";", ","), code)
    is_inside, opened, begin = [False], [], 0
    for brace in re.finditer(r"[{};]", code):
        head, line = code[begin : brace.start()].rstrip(), code.count("\n", 0, brace.start()) + 1
        begin = brace.end()
        if brace[0] == "{":
            is_function = head.endswith("=>") or (head.endswith(")") and not CONTROL.match(head))
            opened.append(line if is_function and not is_inside[-1] else 0)
            is_inside.append(is_inside[-1] or is_function)
        elif brace[0] == "}":
            is_inside.pop()
            first = opened.pop()
            if first:
                yield first, line - first + 1


def python_functions(text):
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            yield node.lineno, node.end_lineno - node.lineno + 1


def sources():
    """(path, text, its functions)."""
    for folder in ("include", "src", "scripts", "python"):
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in (".h", ".cpp"):
                yield path, path.read_text(), cpp_functions
            elif path.suffix == ".js":
                yield path, path.read_text(), javascript_functions
            elif path.is_file() and (path.suffix == ".py" or path.read_bytes().startswith(b"#!/usr/bin/python3")):
                yield path, path.read_text(), python_functions


def test_functions_are_short():
    long = [f"{path.relative_to(ROOT)}:{first}: a function of {lines} lines"
            for path, text, functions in sources() for first, lines in functions(text) if lines > MOST_OF_FUNCTION]
    assert not long, "\n".join(long)


def test_long_files_say_why():
    silent = [str(path.relative_to(ROOT)) for path, text, _ in sources()
              if text.count("\n") > MOST_OF_FILE and "file is long" not in " ".join(text[:2000].replace("//", "").split())]
    assert not silent, silent


def test_what_a_function_of_cpp_is():
    text = """
#define BRACE(x) { x
namespace a {  // {
struct alignas(64) B final : C<decltype(d())> {
  B(int e) : e_{e}, f_(0) {
    if (e == '{') { call("}"); }
  }
  int e_{0};
  enum class Kind { kOne, kTwo };
};
constexpr int kTable[] = {1'000, f(2), 3};
template <typename T>
T g(T x) noexcept {
  const auto h = [&](int i) {
    return R"(
})" + i;
  };
  return h(x);
}
}  // namespace a
"""
    found = {first: lines for first, lines in cpp_functions(text) if lines > 1}
    assert found == {5: 3, 13: 7}


def test_what_a_function_of_javascript_is():
    text = """
const LEAST = { a: 1, b: "{" };  // {
export class Strip {
  draw(now) {
    for (const [k, v] of now) {
      if (k) call(`} ${v}`);
    }
  }
  get size() { return 0; }
}
const link = new Link("page", {
  library: (m) => { take(m); },
}, () => {
  done();
});
for (let i = 0; i < f(2); ++i) {
  listen(i);
}
async function ask(what, given = () => ({})) {
  return given();
}
"""
    assert list(javascript_functions(text)) == [(4, 5), (9, 1), (12, 1), (13, 3), (19, 3)]


def test_what_a_function_of_python_is():
    assert sorted(python_functions("async def a():\n    def b():\n        pass\n    return b\n")) == [(1, 4), (2, 2)]
