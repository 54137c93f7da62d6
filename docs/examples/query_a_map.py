"""Ask a saved map in words: razer run FOLDER -o OUT, then this with OUT."""

import sys

import razer

panoptic = razer.load_map(sys.argv[1])
answer = panoptic.query(sys.argv[2])
if not answer.found:
    print("not in this map")
for hit in answer.best(5).hits:
    center = hit.object.box.center.round(2)
    print(f"{hit.class_guess} #{hit.object.id} at {center}, probability {hit.score:.2f}")
