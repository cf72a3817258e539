"""The page of a report: one HTML file that needs nothing else."""

from affectsim_data.reports.page.examples import Example
from affectsim_data.reports.page.findings import findings
from affectsim_data.reports.page.writing import page_text, write_page

__all__ = ["Example", "findings", "page_text", "write_page"]
