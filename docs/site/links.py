"""Markdown pages and their links."""
import re
import subprocess

LINK = re.compile(r"!?\[(?:[^\[\]]|\[[^\]]*\])*\]\(([^()\s]+)\)")
FENCED = re.compile(r"^(`{3,})[^\n]*\n.*?^\1 *$", re.DOTALL | re.MULTILINE)
CODE = re.compile(FENCED.pattern + r"|`[^`\n]*`", re.DOTALL | re.MULTILINE)


def pages(root):
    """Returns the Markdown files: those of the git repository, or without git, those outside of build folders."""
    listed = subprocess.run(["git", "-C", root, "ls-files", "-co", "--exclude-standard", "*.md"],
                            capture_output=True, text=True, check=False)
    if listed.returncode == 0:
        return sorted(path for path in (root / name for name in listed.stdout.splitlines())
                      if path.is_file())
    return sorted(path for path in root.rglob("*.md")
                  if not re.match(r"build|out|\.", path.relative_to(root).parts[0]))


def anchors(text):
    """Returns the anchors of the headings, as GitHub and Python-Markdown derive them."""
    found, counts = set(), {}
    for heading in re.findall(r"^#{1,6} +(.*?) *#*$", FENCED.sub("", text), re.MULTILINE):
        heading = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
        name = re.sub(r"\s", "-", re.sub(r"[^\w\s-]", "", heading).strip().lower())
        count = counts[name] = counts.get(name, -1) + 1
        found.add(f"{name}-{count}" if count else name)
    return found


def dead_links(root):
    """Returns 'PAGE: TARGET' of each dead link, and the number of working links."""
    dead, alive = [], 0
    texts = {}
    for page in pages(root):
        for target in LINK.findall(CODE.sub("", page.read_text("utf-8"))):
            if re.match(r"[a-z]+:", target):
                continue
            name, _, anchor = target.partition("#")
            path = (page.parent / name).resolve() if name else page
            inside = path.is_relative_to(root) and path.exists()
            if inside and anchor:
                if path not in texts:
                    texts[path] = anchors(path.read_text("utf-8"))
                inside = anchor in texts[path]
            if inside:
                alive += 1
            else:
                dead.append(f"{page.relative_to(root)}: {target}")
    return dead, alive
