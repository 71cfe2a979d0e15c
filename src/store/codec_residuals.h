/* What is left of posts when what their neighbours foretell is taken off. Encoding only. */
#ifndef FURROW_STORE_CODEC_RESIDUALS_H
#define FURROW_STORE_CODEC_RESIDUALS_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"

/*
 * Zigzagged residuals of side^2 posts. A post is foretold as left + up - corner; with `slope`, and
 * from a row's third post on, that difference between rows is foretold to grow as it did one post
 * before. Row 0 stands on a row of `first`. Where a hole is (CODEC_NODATA), what is foretold is
 * taken as the post, so its residual is 0. `filled`: side^2 posts of scratch.
 */
void store_residuals_take(const int32_t *posts, uint32_t side, uint32_t first, bool slope, bool holes,
		    int32_t *filled, uint32_t *rest);

#endif
