"""What is in an FMU."""

import zipfile
from xml.etree import ElementTree


def description(path: str) -> ElementTree.Element:
    """The model description."""
    with zipfile.ZipFile(path) as fmu:
        return ElementTree.fromstring(fmu.read("modelDescription.xml"))
