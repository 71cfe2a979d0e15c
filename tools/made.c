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
