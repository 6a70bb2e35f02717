"""The length of our functions and files: a function has at most 40 lines, and a file of more than 450 says why."""

import ast
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[2]
MOST_OF_FUNCTION, MOST_OF_FILE = 40, 450  # lines
NO_CODE = re.compile(r'R"(\w*)\(.*?\)\1"|//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'(?!\w)|^[ \t]*#(?:[^\n]*\\\n)*[^\n]*', re.S | re.M)
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


def test_what_a_function_of_python_is():
    assert sorted(python_functions("async def a():\n    def b():\n        pass\n    return b\n")) == [(1, 4), (2, 2)]
