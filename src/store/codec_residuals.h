/* Computes residuals: the difference between each post and its prediction from its neighbours. For encoding only. */
#ifndef FURROW_STORE_CODEC_RESIDUALS_H
#define FURROW_STORE_CODEC_RESIDUALS_H

#include <stddef.h>
#include <stdint.h>

#include "base/base.h"

/*
 * Computes zigzagged residuals of side^2 posts. The prediction of a post is left + up - corner. With `slope`, from a row's third
 * post on, the difference between the rows is predicted to grow as it did one post before. The row before row 0 counts as
 * `first` everywhere. A hole (CODEC_NODATA) gets the prediction as its post, so its residual is 0. `filled`: side^2 posts of
 * scratch.
 */
void store_residuals_take(const int32_t *posts, uint32_t side, uint32_t first, bool slope, bool holes,
		    int32_t *filled, uint32_t *rest);

#endif
