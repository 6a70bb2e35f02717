#!/usr/bin/python3
"""Prints the docstrings of the type stubs as a C++ table, for help() in Python.

    python/stub_docs.py python/raven2_trainer/__init__.pyi >build/docs_table.h
"""
import ast
import inspect
import json
import pathlib
import sys


def docs(tree):
    """(name, text) of classes and of what they have."""
    for one in tree.body:
        if not isinstance(one, ast.ClassDef):
            continue
        for name, node in [(one.name, one)] + [(f"{one.name}.{each.name}", each) for each in one.body if isinstance(each, ast.FunctionDef)]:
            text = ast.get_docstring(node)
            if text:
                yield name, inspect.cleandoc(text)


def main():
    tree = ast.parse(pathlib.Path(sys.argv[1]).read_text(encoding="utf-8"))
    print("// Made by python/stub_docs.py.\n#pragma once\n")
    print("constexpr std::pair<const char*, const char*> kDocs[] = {")
    for name, text in docs(tree):
        print(f"    {{{json.dumps(name)}, {json.dumps(text)}}},")
    print("};")


if __name__ == "__main__":
    main()
