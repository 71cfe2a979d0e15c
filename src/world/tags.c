/*
 * Which body each tag of forces belongs to. Tags are given out one after another, so a table by tag leads from forces that arrive to their
 * body. It has the latest tags; of an older one, or without memory for the table, the caller looks at all bodies.
 */
#include <string.h>

#include "world/internal.h"

#define MOST 65536 /* tags in the table: more than are ever in flight, in all but the largest worlds */

void world_tags_add(struct world_tags *tags, uint64_t tag, size_t body)
{
	if (tag != tags->first + tags->count)
		*tags = (struct world_tags){.first = tag, .bodies = tags->bodies, .room = tags->room, .most = tags->most};
	if (tags->count == tags->room) {
		const size_t room = tags->room > 0 ? 2 * tags->room : 256;
		size_t *bodies = room <= tags->most + MOST ? mem_realloc(tags->bodies, room, sizeof *bodies) : NULL;
		if (bodies != NULL) {
			tags->bodies = bodies;
			tags->room = room;
		} else { /* the older half goes */
			const size_t half = tags->count - tags->count / 2;
			memmove(tags->bodies, tags->bodies + half, (tags->count - half) * sizeof *tags->bodies);
			tags->first += half;
			tags->count -= half;
		}
	}
	if (tags->room > 0)
		tags->bodies[tags->count++] = body;
	tags->most = body > tags->most ? body : tags->most;
}

bool world_tags_find(const struct world_tags *tags, uint64_t tag, size_t *body)
{
	if (tag < tags->first || tag - tags->first >= tags->count)
		return false;
	*body = tags->bodies[tag - tags->first];
	return true;
}

void world_tags_free(struct world_tags *tags)
{
	mem_free(tags->bodies);
	*tags = (struct world_tags){.first = 0};
}
