/* Hands: what each of several threads needs to compute contacts and regions that share no post. */
#include "base/memory.h"
#include "bearing/internal.h"

/* A hand has the rule and the law of the whole, and no memory of its own yet. */
static struct bearing *hand_of(struct bearing *main)
{
	struct bearing *hand = mem_alloc(1, sizeof *hand);
	if (hand == NULL)
		return NULL;
	*hand = *main;
	hand->main = main;
	hand->hands = NULL;
	hand->hand_count = 0;
	hand->members = NULL;
	hand->others = NULL;
	hand->rests = NULL;
	hand->claims = NULL;
	hand->member_room = hand->claim_room = 0;
	hand->window = (struct bearing_window){.posts = 0};
	hand->active = hand->next = (struct soil_block_set){.count = 0};
	hand->tally = (struct deform_tally){.compacted = 0};
	hand->held = NULL;
	hand->regions = NULL;
	hand->memory = NULL;
	hand->held_room = hand->held_count = hand->region_count = hand->region_room = hand->memory_room = 0;
	hand->contacts = hand->feels = hand->slid = hand->results = hand->results_most = 0;
	return hand;
}

enum status bearing_hands_need(struct bearing *bearing, size_t count)
{
	if (count <= bearing->hand_count + 1)
		return STATUS_OK;
	TRY(mem_resize(&bearing->hands, count - 1, sizeof *bearing->hands, "bearing soil"));
	while (bearing->hand_count + 1 < count) {
		struct bearing *hand = hand_of(bearing);
		TRY_MEM(hand, "bearing soil");
		bearing->hands[bearing->hand_count++] = hand;
	}
	return STATUS_OK;
}

struct bearing *bearing_hand(struct bearing *bearing, size_t number)
{
	return number == 0 ? bearing : bearing->hands[number - 1];
}

static enum status join_set(struct soil_block_set *set, struct post_rect world, struct soil_block_set *from)
{
	for (size_t i = 0; i < from->count; i++)
		TRY(soil_active_add(set, world, from->blocks[i]));
	soil_block_set_clear(from);
	return STATUS_OK;
}

enum status bearing_hands_join(struct bearing *bearing)
{
	for (size_t i = 0; i < bearing->hand_count; i++) {
		struct bearing *hand = bearing->hands[i];
		struct deform_tally *to = &bearing->tally, *from = &hand->tally;
		to->compacted += from->compacted;
		to->refused += from->refused;
		to->confined += from->confined;
		to->sunk += from->sunk;
		to->slid += from->slid;
		*from = (struct deform_tally){.compacted = 0};
		bearing->contacts += hand->contacts;
		bearing->feels += hand->feels;
		bearing->slid += hand->slid;
		bearing->results += hand->results;
		hand->contacts = hand->feels = hand->slid = hand->results = 0;
		TRY(join_set(&bearing->active, bearing->world, &hand->active));
		TRY(join_set(&bearing->next, bearing->world, &hand->next));
	}
	bearing->results_most = bearing->results > bearing->results_most ? bearing->results : bearing->results_most;
	return STATUS_OK;
}

void bearing_hands_finish(struct bearing *bearing)
{
	for (size_t i = 0; i < bearing->hand_count; i++) {
		struct bearing *hand = bearing->hands[i];
		soil_block_set_finish(&hand->active);
		soil_block_set_finish(&hand->next);
		bearing_window_finish(&hand->window);
		bearing_members_finish(hand);
		mem_free(hand);
	}
	mem_free(bearing->hands);
}
