/* Names of a copy of the law that is compiled for one instruction set: LANES_OF is the start of each name. */
#ifndef FURROW_TESTS_LANES_NAMES_H
#define FURROW_TESTS_LANES_NAMES_H

#define LANES_PASTE(of, name) of##_##name
#define LANES_NAME(of, name) LANES_PASTE(of, name)
#define soil_work_create LANES_NAME(LANES_OF, work_create)
#define soil_work_destroy LANES_NAME(LANES_OF, work_destroy)
#define soil_sink_body LANES_NAME(LANES_OF, sink_body)
#define soil_feel LANES_NAME(LANES_OF, feel)
#define soil_probe LANES_NAME(LANES_OF, probe)
#define soil_contact_begin LANES_NAME(LANES_OF, contact_begin)
#define soil_contact_gather LANES_NAME(LANES_OF, contact_gather)
#define soil_contact_evaluate LANES_NAME(LANES_OF, contact_evaluate)
#define soil_contact_turn LANES_NAME(LANES_OF, contact_turn)
#define soil_contact_tell LANES_NAME(LANES_OF, contact_tell)
#define soil_height_find LANES_NAME(LANES_OF, height_find)
#define soil_bear LANES_NAME(LANES_OF, bear)
#define soil_cover LANES_NAME(LANES_OF, cover)
#define soil_form_of LANES_NAME(LANES_OF, form_of)
#define soil_posts_need LANES_NAME(LANES_OF, posts_need)
#define soil_posts_finish LANES_NAME(LANES_OF, posts_finish)
#define soil_posts_gather LANES_NAME(LANES_OF, posts_gather)
#define soil_posts_width LANES_NAME(LANES_OF, posts_width)
#define soil_posts_below LANES_NAME(LANES_OF, posts_below)

#endif
