/* Misses over the size of the page cache, from the trace of a drive. */
#ifndef FURROW_TOOLS_HTML_CACHE_H
#define FURROW_TOOLS_HTML_CACHE_H

#include "cache_curves.h"
#include "html_run.h"

enum { HTML_LRU, HTML_OPT, HTML_POLICIES };

struct html_cache {
	size_t count; /* of sizes; 0: there are none; `why` tells */
	double slots[CACHE_SIZES_MAX], misses[HTML_POLICIES][CACHE_SIZES_MAX];
	uint64_t accesses, tiles;
	char why[512]; /* one sentence */
};

enum status html_cache_read(const struct html_run *run, struct html_cache *out) FURROW_CHECKED;

#endif
