"""Has a system changed, and what does its noise go with?"""
