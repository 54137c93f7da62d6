"""The page of a map: one HTML file, offline, and the same page for a server."""

from app.page.html import page_html as page_html
from app.page.payload import page_payload as page_payload
