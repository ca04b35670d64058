# SPDX-License-Identifier: Apache-2.0
"""The reference of the site, as Markdown: a section for each public name, with the text of its own declaration.

The headers of C and C++ are split by their layout, which clang-format keeps: a declaration begins on a line of its own
and ends where all its brackets are closed. The comment above it becomes the text of its section. Python's names come
from the stubs and the sources of the package.
"""

import ast
import inspect
import re
import textwrap
from dataclasses import dataclass, field
from pathlib import Path

FENCE = "```"
# The headers whose names `gnosphere` itself has in Python.
CORE = ("scene", "animation", "sensor", "effects", "simulator", "plan", "scan", "batch", "batch_stream", "output", "layout",
        "error")
# Lines of a header that declare nothing.
_SKIPPED = re.compile(r"#(?!define GNO_(?!API)\w+ )|namespace|extern|public:|\}")
_NAMES = (
    re.compile(r"^#define (\w+)"),
    re.compile(r"^typedef [^{(]*?\b(\w+);"),
    re.compile(r"^typedef \w+ \(\*?(\w+)\)\("),
    re.compile(r"^(?:typedef )?(?:struct|class|enum class|enum|union) (?:GNO\w+_API )?(\w+)"),
    re.compile(r"^using (\w+) ="),
    re.compile(r"(operator[^\s\w]+|~?\w+)\("),
    re.compile(r"(\w+)(?: = |\{|;|\[)"),
)


@dataclass
class Section:
    """A public name: what is said about it, and its declarations."""

    name: str
    others: list[str] = field(default_factory=list)  # names that the same comment speaks of
    prose: list[str] = field(default_factory=list)
    code: list[str] = field(default_factory=list)
    members: list["Section"] = field(default_factory=list)


def _bare(line: str) -> str:
    """A line of C++ without its comments and texts."""
    return re.sub(r'//.*|/\*.*?\*/|/\*.*|"(?:\\.|[^"\\])*"', "", line)


def _name_of(lines: list[str]) -> str:
    text = re.sub(r"^template <.*?>$", "", "\n".join(map(_bare, lines)), flags=re.M).strip()
    if text.startswith("enum {"):  # the values of the type above them
        return ""
    for pattern in _NAMES:
        if found := pattern.search(text):
            return found[1]
    raise ValueError(f"no name in {text!r}")


def _header_blocks(text: str):
    """Yields (comment, declaration, whether another declaration is on the line above) as lists of lines; a comment that
    a blank line follows has no declaration, and the ruler of a part is a comment that begins with '# '."""
    comment: list[str] = []
    lines: list[str] = []
    depth = 0
    open_comment = joined = False
    for line in text.split("\n"):
        bare = line.strip()
        if not lines:
            if open_comment or re.match(r"/\*(?!.*\*/.*\S)", bare):
                open_comment = "*/" not in bare
                if ruler := re.match(r"/\* -{9,} (.*) \*/", bare):
                    yield [f"# {ruler[1].capitalize()}"], [], False
                else:
                    comment.append(re.sub(r"^(/\*|\*(?!/)) ?|\s*\*/$", "", bare))
                continue
            if bare.startswith("///"):
                comment.append(bare[3:].removeprefix(" "))
                continue
            if bare in ("private:", "protected:"):
                return
            if not bare or bare.startswith("//") or _SKIPPED.match(bare):
                if comment:
                    yield comment, [], False
                comment, joined = [], False
                continue
        lines.append(line)
        code = _bare(line).rstrip()
        depth += sum(code.count(c) for c in "({[") - sum(code.count(c) for c in ")}]")
        if depth == 0 and (code.endswith((";", "}")) or code.startswith("#define")):
            yield comment, lines, joined
            comment, lines, joined = [], [], True


# A comment of C, alone on its lines; a run of lines that are comments; a declaration of a function without its body.
_C_COMMENT = re.compile(r"^( *)/\*(.*?)\*/$", re.M | re.S)
_COMMENT = re.compile(r"^( *)/// .*(\n\1/// .*)*$", re.M)
_FUNCTION = re.compile(r"^( *)[^\s/](?:[^\n{]|\{\})*\((?:[^{;]|\{\})*\)[^{;]*;$", re.M)


def _shown(lines: list[str]) -> list[str]:
    """A declaration without what is private, each comment above what it is about, in lines that fit the page."""
    private = next((i for i, line in enumerate(lines) if line.strip() in ("private:", "protected:")), len(lines) - 1)
    text = "\n".join([line for line in lines[:private] if line.strip() != "public:"] + lines[-1:])
    text = re.sub(r"\bGNO(SPHERE)?_API ", "", text)
    text = _C_COMMENT.sub(lambda m: re.sub(r"\n *\* ", f"\n{m[1]}/// ", f"{m[1]}///{m[2]}"), text)
    text = re.sub(r" /\* (.*) \*/$", r" ///< \1", text, flags=re.M)
    text = re.sub(r"^( *)(\S.*?) *///< (.*)$", r"\1/// \3\n\1\2", re.sub(r"\n +///< ", " ", text), flags=re.M)
    text = _COMMENT.sub(lambda m: _wrapped(m[0].replace("/// ", ""), f"{m[1]}/// "), text)
    return _FUNCTION.sub(lambda m: _wrapped(m[0], m[1], "    "), text).split("\n")


def _wrapped(text: str, indent: str, further: str = "") -> str:
    return textwrap.fill(" ".join(text.split()), 75, initial_indent=indent, subsequent_indent=indent + further)


def _sections(text: str, scope: str = "") -> list[Section]:
    made: list[Section] = []
    for comment, lines, joined in _header_blocks(text):
        if not lines:
            made.append(Section("", prose=comment))
            continue
        name = _name_of(lines) or made[-1].name
        if name.startswith(("operator", "~")) or (scope and name == scope.rstrip(":") and "&&" in lines[0]):
            continue  # what moves and copies is said by the type
        if re.fullmatch(r"(struct|class) \w+;", lines[0].strip()):
            continue  # a name that another header declares
        title = scope + name
        section = next((s for s in made if title in (s.name, *s.others)), None)
        if section is None and joined and not comment and "///<" not in lines[0]:
            section = made[-1]  # the comment above speaks of this, too
            section.others.append(title)
        if section is None:
            made.append(section := Section(title))
        section.prose += [*([""] if section.prose and comment else []), *comment]
        if lines[0].startswith("class GNOSPHERE_API "):
            indented = "\n".join(line.removeprefix("  ") for line in lines[1:-1])
            section.members = _sections(indented, f"{name}::")
            section.code += _shown([lines[0].removesuffix(" {") + ";"])
        else:
            section.code += _shown(lines)
    return made


def _escaped(prose: list[str]) -> str:
    """A comment as Markdown: only what is in backquotes is more than text."""
    parts = re.split(r"(`[^`]*`)", "\n".join(prose))
    parts[::2] = [re.sub(r"([*_\[\]|])", r"\\\1", part).replace("<", "&lt;") for part in parts[::2]]
    return "".join(parts)


def _markdown(sections: list[Section], language: str, level: int) -> str:
    text = ""
    for section in sections:
        prose = _escaped(section.prose)
        if not section.name:
            text += f"## {prose[2:]}\n\n" if prose.startswith("# ") else f"{prose}\n\n"
            continue
        anchors = "".join(f'<span id="{name.lower()}"></span>' for name in section.others)
        text += f"{'#' * level} {section.name}\n\n{anchors}{prose}\n\n"
        if section.code:
            text += f"{FENCE} {language}\n" + "\n".join(section.code) + f"\n{FENCE}\n\n"
        text += _markdown(section.members, language, level + 1)
    return text


def _header_page(file: Path, title: str, language: str) -> str:
    text = file.read_text(encoding="utf-8")
    if language == "c":
        about, rest = re.match(r"/\* SPDX.*?\n \*\n(.*?)\*/(.*)", text, re.S).groups()
        about = re.sub(r"^ \* ?", "", about, flags=re.M)
    else:
        about, rest = re.match(r"// SPDX.*?\n((?:// .*\n)*)#pragma once(.*)", text, re.S).groups()
        about = re.sub(r"^// ", "", about, flags=re.M)
    level = 3 if language == "c" else 2
    return f"# {title}\n\n{_escaped([about])}\n\n{_markdown(header_sections(rest), language, level)}"


def header_sections(text: str) -> list[Section]:
    """The public names of a header. GNO_INIT(type, ...) of C's headers defines type_init()."""
    initialised = re.findall(r"^GNO_INIT\((\w+),", text, re.M)
    sections = _sections(re.sub(r"^#define GNO_INIT(.*\\\n)*.*$|^GNO_INIT\((?:.|\n)*?\)$", "", text, flags=re.M))
    for name in initialised:
        next(s for s in sections if name in (s.name, *s.others)).code.append(f"{name} {name}_init(void);")
    return sections


def _plain(text: str) -> str:
    """Python's text of a signature without what only type checkers need."""
    text = re.sub(r"Annotated\[(.*?\]), dict\(.*?\)\]", r"\1", text)
    return re.sub(r"\b(numpy\.typing|numpy|gnosphere\._gnosphere|collections\.abc|npt|np|gno)\.", "", text)


def _marks(node: ast.FunctionDef) -> set[str]:
    """The last words of a function's decorators."""
    return {ast.unparse(mark).split(".")[-1] for mark in node.decorator_list}


def _signature(node: ast.FunctionDef, name: str) -> str:
    if "property" in _marks(node):
        return f"{name}: {_plain(ast.unparse(node.returns))}" if node.returns else name
    arguments = re.sub(r"^self(, (/, )?)?|, /$", "", ast.unparse(node.args))
    returns = f" -> {_plain(ast.unparse(node.returns))}" if node.returns and name[0].islower() else ""
    return f"{name}({_plain(arguments)}){returns}"


def _python_sections(body: list[ast.stmt], scope: str = "") -> list[Section]:
    """The public names of a module or a class. What a class has is in `members`, but for classes within it."""
    made: list[Section] = []
    following = [*body[1:], ast.Pass()]
    for node, after in zip(body, following):
        doc = ""
        if isinstance(node, (ast.Assign, ast.AnnAssign)):
            target = node.target if isinstance(node, ast.AnnAssign) else node.targets[0]
            name = getattr(target, "id", "_")
            said = name if isinstance(node, ast.Assign) and scope[:1].isupper() else _plain(ast.unparse(node))
            if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant):
                doc = inspect.cleandoc(str(after.value.value))
        elif isinstance(node, ast.ClassDef):
            name, doc = node.name, ast.get_docstring(node) or ""
            bases = ", ".join(map(ast.unparse, node.bases))
            said = f"class {scope}{name}({bases})" if bases else f"class {scope}{name}"
        elif isinstance(node, ast.FunctionDef) and "setter" not in _marks(node):
            name, doc = node.name, ast.get_docstring(node) or ""
            said = _signature(node, scope.rstrip(".") if name == "__init__" else name)
        else:
            continue
        if name.startswith(("_", "pytest_")) and name != "__init__":
            continue
        section = next((s for s in made if s.name == scope + name), None)
        if section is None:
            made.append(section := Section(scope + name))
        section.prose += [doc] if doc and doc not in section.prose else []
        section.code.append(said)
        if isinstance(node, ast.ClassDef):
            section.members = _python_sections(node.body, f"{scope}{name}.")
    return made


def _python_markdown(sections: list[Section], level: int = 2) -> str:
    text = ""
    for section in sections:
        code = "\n".join(textwrap.fill(c, 75, subsequent_indent="    ") for c in section.code)
        text += f"{'#' * level} {section.name}\n\n{_escaped(section.prose)}\n\n{FENCE} python\n{code}\n{FENCE}\n\n"
        inner = [member for member in section.members if member.code[0].startswith("class ")]
        for member in section.members:
            if member not in inner:
                said = "`, `".join(member.code)
                text += f"- `{said}`" + (f": {_escaped([' '.join(member.prose)])}" if member.prose else "") + "\n"
        text += "\n" + _python_markdown(inner, level + 1)
    return text


def _python_page(title: str, files: list[Path], only: set[str] = frozenset(), scoped: bool = False) -> str:
    """The names of files, or `only` some of them; with their file's name before them if `scoped`."""
    text = f"# {title}\n\n"
    for file in files:
        module = ast.parse(file.read_text(encoding="utf-8"))
        about = ast.get_docstring(module) or ""
        if not only or file.stem == "__init__":
            text += (about if "\n    " in about else _escaped([about])) + "\n\n"
        sections = _python_sections(module.body, f"{file.stem}." if scoped else "")
        text += _python_markdown([section for section in sections if not only or section.name in only])
    return text


def _core_pages(folder: Path, stub: Path):
    """The names of `gnosphere` itself, by the header of C++ that has them."""
    left = {section.name: section for section in _python_sections(ast.parse(stub.read_text(encoding="utf-8")).body)}
    for page in CORE:
        here = []
        for section in header_sections((folder / f"{page}.hpp").read_text(encoding="utf-8")):
            for name in (section.name, *section.others):
                snake = name if name[:1].isupper() else re.sub(r"([A-Z])", r"_\1", name).lower()
                here += [left.pop(n) for n in (snake, snake.upper().removeprefix("K_")) if n in left]
        if page == CORE[-1]:
            here += left.values()
        yield page, f"# gnosphere: {page}\n\n{_python_markdown(here)}"


def pages(root: Path, package: Path | None):
    """Yields (place, text) of each page. Without `package`, the folder of an installed Python package, the pages that
    are made of its stubs say that they are left out."""
    headers = sorted((root / "include" / "gnosphere").rglob("*.hpp"))
    shown = [h for h in headers if h.stem not in ("export", "gnosphere") and "compat" not in h.parts]
    listed = ""
    for header in shown:
        name = header.relative_to(root / "include").as_posix()
        yield f"reference/cpp/{header.stem}.md", _header_page(header, name, "cpp")
        listed += f"- [{name}]({header.stem}.md)\n"
    about = "`#include <gnosphere/gnosphere.hpp>` has all but `vulkan.hpp`, `ros2.hpp` and `eval`."
    yield "reference/cpp/index.md", f"# C++\n\n{about}\n\n{listed}"
    for header in sorted((root / "include").glob("*.h")):
        yield f"reference/c/{header.stem}.md", _header_page(header, header.name, "c")
    sources = root / "python" / "gnosphere"
    absent = "This copy of the site was made without the Python package, so this part of the reference is not there."
    if package:
        for name, text in _core_pages(root / "include" / "gnosphere", package / "_gnosphere" / "__init__.pyi"):
            yield f"reference/python/core/{name}.md", text
        yield "reference/python/drive.md", _python_page("gnosphere.drive", [package / "_gnosphere" / "drive.pyi"])
        ros2 = [sources / "ros2.py", package / "_gnosphere" / "_ros2.pyi"]
    else:
        for name in (*(f"core/{page}" for page in CORE), "drive"):
            yield f"reference/python/{name}.md", f"# gnosphere: {Path(name).name}\n\n{absent}\n"
        ros2 = [sources / "ros2.py"]
    yield "reference/python/ros2.md", _python_page("gnosphere.ros2", ros2)
    for module in ("adapter", "patterns", "pictures", "primitives", "testing"):
        yield f"reference/python/{module}.md", _python_page(f"gnosphere.{module}", [sources / f"{module}.py"])
    for module in ("helios", "mujoco", "robotics"):
        initial = sources / module / "__init__.py"
        body = ast.parse(initial.read_text(encoding="utf-8")).body
        imported = [statement for statement in body if isinstance(statement, ast.ImportFrom)]
        only = {alias.name for statement in imported for alias in statement.names}
        files = [initial, *(sources / module / f"{statement.module}.py" for statement in imported)]
        yield f"reference/python/{module}.md", _python_page(f"gnosphere.{module}", files, only)
    files = sorted((sources / "engines").glob("*.py"))
    yield "reference/python/engines.md", _python_page("gnosphere.engines", files, scoped=True)
