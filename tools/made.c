#include "made.h"

#include <stdio.h>

void print_made(const struct intake *made)
{
	const struct extent *extent = &made->meta.extent;
	const double posts = (double)extent->width * (double)extent->height, bytes = (double)made->bytes;
	if (made->stored > 0)
		printf("%s: %lld tiles were there from before\n", made->path, (long long)made->stored);
	printf("%s: %lld x %lld posts, %g m apart, levels 0 to %d, %.1f MB (%.2f bytes a post), %.1f s (%.1f million posts a second)\n",
	       made->path, (long long)extent->width, (long long)extent->height, extent->spacing, extent_coarsest(extent), bytes / 1e6,
	       bytes / posts, made->seconds, posts / made->seconds / 1e6);
}

void print_imagery(const struct intake_imagery *made)
{
	const double share = made->source_pixel / made->pixel;
	printf("%s: imagery of %zu source%s, pixels of %g m (the finest source: %.4g m), level %d, WebP %s\n", made->store, made->source_count,
	       made->source_count == 1 ? "" : "s", made->pixel, made->source_pixel, made->finest, made->quality == 0 ? "without loss" : "with loss");
	if (share < 0.7)
		printf("  the source is finer than 8 pixels a post; a store with a finer --spacing keeps its detail\n");
	if (made->quality > 0)
		printf("  quality %d; --lossless keeps every pixel as it was resampled\n", made->quality);
	if (made->dry)
		return;
	if (made->kept > 0)
		printf("  %lld tiles were there from before\n", (long long)made->kept);
	printf("  %lld tiles, %.1f MB, %.1f s\n", (long long)made->tiles, (double)made->bytes / 1e6, made->seconds);
}

void imagery_json(cJSON *object, const struct intake_imagery *made)
{
	json_integer(object, "level", made->finest);
	json_number(object, "pixel", made->pixel);
	json_number(object, "source_pixel", made->source_pixel);
	json_integer(object, "sources", (int64_t)made->source_count);
	json_integer(object, "quality", made->quality);
	json_integer(object, "tiles", made->tiles);
	json_integer(object, "bytes", made->bytes);
	json_number(object, "seconds", made->seconds);
}
