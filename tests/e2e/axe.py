# SPDX-License-Identifier: MIT
"""What axe-core finds on a page that is hard or impossible to use for some people."""

from axe_playwright_python.sync_playwright import Axe

SCRIPT = Axe().axe_script
RUN = """(options) => axe.run({ resultTypes: ["violations"], ...options }).then(({ violations }) => violations
    .filter(({ impact }) => ["serious", "critical"].includes(impact))
    .flatMap(({ id, nodes }) => nodes.map(({ target }) => `${id}: ${target.join(" ")}`)))"""
# By name: the tag cat.color has rules of WCAG AAA, too, which axe-core leaves out otherwise.
COLOURS = {"runOnly": ["color-contrast", "link-in-text-block"]}


def serious(page, options=None) -> list:
    """A line for each serious or critical violation; `options` are those of axe.run()."""
    page.evaluate(SCRIPT)
    return page.evaluate(RUN, options or {})
