"""Reports on many pictures, in the formats that people, programs and CI services read.

Reading order: run_facts, json_report, junit_report, embedded_images, html_report, write.
"""

from .embedded_images import embed_images
from .run_facts import RunFacts
from .write import write_reports

__all__ = ["RunFacts", "embed_images", "write_reports"]
