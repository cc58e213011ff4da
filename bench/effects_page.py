"""Makes docs/effects.md and its pictures from the catalogue: python bench/effects_page.py"""

from pathlib import Path

from flex_ident.commands.effects_catalogue import write_effects_page

if __name__ == "__main__":
    for path in write_effects_page(Path(__file__).resolve().parent.parent / "docs"):
        print(path.name)
